"""What pictures share: plain labels of logarithmic axes, legends without doubles, units of time, round factors."""

import numpy as np
import pytest

from apps.conftest import MARKUP, ticks
from cablewright.apps import style
from cablewright.apps.pictures.print import steps_picture
from cablewright.apps.quantities import enlargement


@pytest.mark.parametrize("span", [1.3, 8.0, 60.0, 1e5, 1e10])
def test_a_logarithmic_axis_has_plain_labels(span):
    with style.drawing():
        drawn = style.figure(6.0, 3.0)
        axes = drawn.add_subplot(xscale="log", xlim=(0.7, 0.7 * span))
        style.log_ticks(axes.xaxis, *axes.get_xlim())
        style.png(drawn)
        low, high = axes.get_xlim()
        shown = [
            text.get_text()
            for text, at in zip(axes.get_xticklabels(), axes.get_xticks(), strict=True)
            if low <= at <= high
        ]
        minor = [text.get_text() for text in axes.get_xticklabels(minor=True)]
    assert len(shown) >= 2
    assert all(shown)
    assert not any("$" in text for text in shown)
    assert not any(minor)


def test_computing_times_have_plain_labels():
    with style.drawing():
        drawn = steps_picture(np.geomspace(1.2e-3, 2.9e-3, 200))
        style.png(drawn)
        texts = [text.get_text() for axis in drawn.axes for text in (*axis.get_xticklabels(), *axis.get_yticklabels())]
    assert not any("$" in text for text in texts)


@pytest.mark.parametrize(
    ("value", "text"), [(1e-6, "10⁻⁶"), (2e-5, "2·10⁻⁵"), (1e-3, "0.001"), (0.5, "0.5"), (2e5, "200000"), (1e7, "10⁷")]
)
def test_ticks_beyond_a_thousandth_are_powers(value, text):
    assert style.power(value) == text


def test_a_legend_names_what_two_axes_share_once():
    with style.drawing():
        drawn = style.figure(4.0, 3.0)
        left, right = drawn.subplots(1, 2)
        for axes, names in ((left, "ab"), (right, "bcc")):
            for name in names:
                axes.plot([0.0, 1.0], label=name)
        style.legend_below(drawn, left, right, columns=3)
    assert [text.get_text() for text in drawn.legends[0].get_texts()] == ["a", "b", "c", "c"]


def test_units_of_time():
    assert [style.time_unit(each) for each in (100.0, 200.0, 20_000.0)] == [(1.0, "s"), (60.0, "min"), (3600.0, "h")]


def test_enlargements_are_round_and_never_shrink():
    found = [enlargement(goal, size) for goal, size in ((1.0, 0.3), (1.0, 0.1), (1.0, 0.004), (1.0, 2.0), (1.0, 0.0))]
    assert found == pytest.approx([2.0, 10.0, 200.0, 1.0, 1.0])


def test_a_log_axis_without_care_would_be_noticed():
    with style.drawing():
        drawn = style.figure(4.0, 3.0)
        axes = drawn.add_subplot()
        axes.set(xscale="log", xlim=(0.3, 40.0))
        assert any(MARKUP.search(text) for text in ticks(drawn))
        style.log_ticks(axes.xaxis, 0.3, 40.0)
    assert not any(MARKUP.search(text) for text in ticks(drawn))
    assert "0.5" in ticks(drawn)


@pytest.mark.parametrize(("low", "high"), [(1.0, 1.4), (0.02, 0.9), (1e-9, 1e9), (3e-4, 7.0), (900.0, 2e6)])
def test_ticks_of_any_log_axis_are_plain(low: float, high: float):
    with style.drawing():
        drawn = style.figure(4.0, 3.0)
        axes = drawn.add_subplot()
        axes.set(yscale="log", ylim=(low, high))
        style.log_ticks(axes.yaxis, low, high)
    told = [text for text in ticks(drawn) if text]
    assert not any(MARKUP.search(text) for text in told)
    assert len(told) >= 2

"""Results as data frames and grids: the numbers of the result, under the names that people type."""

import sys

import numpy as np
import pytest

import cablewright as cw

pandas = pytest.importorskip("pandas")
pytest.importorskip("xarray")
ROBOT = cw.load("house-printer")
GRID = np.stack(np.meshgrid([0.0, 1.0], [0.0, 2.0, 3.0], [3.0], indexing="ij"), axis=-1).reshape(-1, 3)


def test_a_batch_has_a_row_for_each_pose() -> None:
    held = cw.inverse(ROBOT, GRID)
    table = held.to_frame()
    assert len(table) == len(GRID)
    assert table[["x", "y", "z"]].to_numpy() == pytest.approx(GRID)
    assert table["tensions.south-west"].to_numpy() == pytest.approx(held.tensions[:, 0])
    assert table.attrs["robot"] == "house-printer"


def test_a_single_result_has_a_row_for_each_line_or_mode() -> None:
    held = cw.inverse(ROBOT, GRID[0])
    table = held.to_frame()
    assert list(table["lines"]) == [line.name for line in ROBOT.lines]
    assert table["tensions"].to_numpy() == pytest.approx(held.tensions)
    assert cw.modes(held).to_frame()["frequencies"].to_numpy() == pytest.approx(cw.modes(held).frequencies)


def test_a_grid_of_places_is_a_data_set() -> None:
    held = cw.inverse(ROBOT, GRID)
    grid = held.to_xarray()
    assert dict(grid.sizes) == {"x": 2, "y": 3}
    assert float(grid["margin"].sel(x=1.0, y=2.0)) == pytest.approx(held.margin()[4])
    errors = cw.accuracy(ROBOT, cw.Places.plane(ROBOT, 1.0, 4.0, 4.0), method=cw.FirstOrder())
    assert dict(errors.to_xarray().sizes) == {"x": 3, "y": 3}
    inside = cw.count_nodes(cw.load("jung2020"), "closed-form", grid=5)
    assert int(inside.to_xarray()["inside"].sum()) == inside.counted


def test_places_that_fill_no_grid_are_rejected() -> None:
    with pytest.raises(cw.InputError, match="fill no grid"):
        cw.inverse(ROBOT, GRID[:5]).to_xarray()
    with pytest.raises(cw.InputError, match="it has no positions"):
        cw.inverse(ROBOT, GRID[0]).to_xarray()


def test_tables_of_trajectories_tensions_and_wrenches() -> None:
    way = cw.Trajectory.through([[0, 0, 3], [1, 1, 4]], speed=1.0, acceleration=1.0, period=0.5)
    found = cw.inverse_dynamics(ROBOT, way).to_frame()
    assert found["v.x"].to_numpy() == pytest.approx(way.velocities[:, 0])
    assert {"time", "tension.south-west", "power.north-east"} <= {*found.columns}
    compared = cw.compare_tensions(cw.load("jung2020"), [[0.2, 0.1, 0.9], [0.0, 0.0, 0.8]]).to_frame()
    assert len(compared) == 8
    assert list(compared["method"].unique()) == ["closed-form", "improved-closed-form", "least-norm", "exact"]
    assert len(cw.capacity(cw.load("jung2020"), [[0.2, 0.1, 0.9]] * 3).to_frame()) == 3


def test_without_the_extra_one_line_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(cw.EnvironmentFault, match=r"pip install 'cablewright\[frames\]'"):
        cw.inverse(ROBOT, GRID).to_frame()

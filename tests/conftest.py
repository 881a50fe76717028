"""What tests of several ranks share: small jobs to print, and no clock that a busy computer could lose against.

Linear algebra has one thread in each test process: threads of several processes on the same cores wait for each other.
A suite in the background of a shell hears interrupts, so that the programs that it starts and interrupts end.
"""

from __future__ import annotations

import gc
import io
import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import hypothesis
import pytest

assert "numpy" not in sys.modules  # which reads the variable once
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
hypothesis.settings.register_profile("unhurried", deadline=None)
hypothesis.settings.register_profile("brief", deadline=None, max_examples=30)
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_configure(config: pytest.Config) -> None:
    """Where slow tests are left out, fewer examples of a law are drawn too: see `cases.often`."""
    pace = "brief" if "not slow" in config.option.markexpr else "unhurried"
    hypothesis.settings.load_profile(pace)
    os.environ["CABLEWRIGHT_TESTS"] = pace


def pytest_collection() -> None:
    """Thousands of tests stay to the end: the collector has nothing to find among them."""
    gc.disable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Check two assumptions of `make test` on test files.

    No import of one calls a kernel, since each worker imports them all and would compile it. Tests by the clock
    that are not slow are in `tests/apps`.
    """
    kernels = sys.modules.get("cablewright.kernels")
    assert kernels is None or kernels.prepared_count() == 0, "a test file calls a kernel when it is imported"
    by_clock = [item for item in items if item.get_closest_marker("clock") and not item.get_closest_marker("slow")]
    assert all(item.nodeid.startswith("tests/apps/") for item in by_clock), by_clock


def pytest_collection_finish() -> None:
    """Leave the tests out of all later collections too."""
    gc.freeze()
    gc.enable()


def square(layers: int = 3) -> str:
    """G-code of a square of one metre, laid *layers* times on itself; it starts in a corner, the file's zero."""
    lines = ["G21", "G90", "M83"]
    for layer in range(layers):
        lines += [f"G1 Z{20 * layer} F6000", *(f"G1 X{x} Y{y} E10" for x, y in CORNERS)]
    return "\n".join(lines) + "\n"


CORNERS = [(1000, 0), (1000, 1000), (0, 1000), (0, 0)]  # mm


@pytest.fixture(scope="session")
def write_job(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Write a job TOML, and its G-code beside it, into a folder of its own; returns the path of the TOML.

    Its motion is not shaped, so that corners and lengths are those of the G-code.
    """

    def write(
        origin: tuple[float, float, float] = (-0.5, -0.5, 1.0),
        name: str = "square",
        gcode: str | None = None,
        scale: float = 1.0,
    ) -> Path:
        folder = tmp_path_factory.mktemp("job")
        (folder / "part.gcode").write_text(square() if gcode is None else gcode)
        job = folder / "job.toml"
        place = [float(x) for x in origin]
        text = f'schema = 1\nname = "{name}"\ngcode = "part.gcode"\nscale = {scale}\norigin = {place}\n'
        job.write_text(text + '[motion]\nshaping = "none"\n')
        return job

    return write


@pytest.fixture(scope="session", autouse=True)
def _own_key(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Searches of tests are signed with a key of their own, not with that of the user."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CABLEWRIGHT_STATE_DIR", str(tmp_path_factory.mktemp("state")))
        yield


@pytest.fixture(scope="module")
def unpaced() -> Iterator[None]:
    """Let the steps of operated machines in this process follow one another: at the pace of the clock they spin."""
    from cablewright.machine.real_time_machine import Paced

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Paced, "step", lambda paced, command: paced._machine.step(command))
        yield


@pytest.fixture(scope="module")
def undrawn() -> Iterator[None]:
    """Replace each picture of a report by a pixel: pictures take most of the time of a short print or check."""
    yield from pixels()


@pytest.fixture
def undrawn_here() -> Iterator[None]:
    """As `undrawn`, for one test of a file whose others look at pictures."""
    yield from pixels()


@pytest.fixture(scope="module")
def unpictured() -> Iterator[None]:
    """Write reports of prints without pictures, in files that write many and look at none."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cablewright.apps.report.print._pictures", lambda *_: {})
        yield


def pixels() -> Iterator[None]:
    """Let pictures be a pixel each while this is suspended."""
    from PIL import Image

    from cablewright.apps import style  # which loads Matplotlib

    out = io.BytesIO()
    Image.new("RGB", (1, 1), "white").save(out, "PNG")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(style, "png", lambda _drawn: out.getvalue())
        yield

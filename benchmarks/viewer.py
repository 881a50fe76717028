"""The page of a run of a million samples, and how fast it turns: ``python -m benchmarks.viewer [FOLDER]``.

Two paths of 140 layers on the house-printer: a smooth one, and one that is rough by 3 mm. Pages go to FOLDER (else
a temporary one). With Chromium installed each is turned for 4 s, in software, all in view and zoomed in by 8 and by 40.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

from cablewright.apps.report.show import show_page
from cablewright.apps.web.check_scene import extent
from cablewright.apps.web.path_scene import PathScene, Quantity, states_along
from cablewright.apps.web.scene import SceneDescription
from cablewright.models.statics import Model
from cablewright.robot import load

SAMPLES = 1_000_000
LAYERS = 140
WORST = 654_321
TURN = """(async () => {
  const v = document.querySelector('.viewer').view, begun = performance.now(), before = v.drawn;
  v.camera.home();
  if (ZOOM > 1) { v.camera.target.set(3.5, 0, 1); v.camera.zoom(ZOOM); }
  while (performance.now() - begun < 4000) {
    v.camera.turn(1, 0); v.changed(true);
    await new Promise((done) => requestAnimationFrame(done));
  }
  return (v.drawn - before) / ((performance.now() - begun) / 1000);
})()"""


def scene(rough: float) -> SceneDescription:
    """A run with a nozzle error of *rough*, m, with six quantities."""
    robot, random = load("house-printer"), np.random.default_rng(1)
    share = np.linspace(0.0, 1.0, SAMPLES)
    angle = 2.0 * np.pi * share * LAYERS
    radius = 3.0 + 0.8 * np.sin(5.0 * angle)
    layer = np.minimum(np.floor(share * LAYERS), LAYERS - 1)
    places = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0.02 * layer])
    places += random.normal(0.0, max(rough, 1e-4), places.shape) * [1.0, 1.0, 0.1]
    error = 0.01 + 0.005 * np.sin(3.0 * angle) + random.normal(0.0, 3e-4, SAMPLES)
    error[WORST] = 0.08
    tensions = 1000.0 + 300.0 * np.cos(angle[:, None] + np.arange(4)) + random.normal(0.0, 1.0, (SAMPLES, 4))
    quantities = [
        Quantity.of("error", "error", "m", error),
        *(Quantity.of(f"{k}", f"tension {k}", "N", tensions[:, k], colours="tension") for k in range(4)),
        Quantity.of("height", "height", "m", places[:, 2]),
    ]
    when, size = 36_000.0 * share, extent(robot)
    laid, number = np.ones(SAMPLES, dtype=bool), layer.astype(int) + 1
    path = PathScene(places, laid, number, size, quantities, when, np.arange(SAMPLES) + 1, worst=WORST)
    states = states_along(Model(robot), places, time=when, worst=WORST)
    return SceneDescription(f"a million samples, rough by {rough:g} m", robot, states, path)


def main() -> None:
    """Write the pages, print their size, and turn them."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else mkdtemp())
    pages = {}
    for name, rough in (("smooth", 0.0), ("rough", 3e-3)):
        begun = time.perf_counter()
        made = scene(rough)
        text = show_page(made)
        pages[name] = folder / f"{name}.html"
        pages[name].write_text(text, encoding="utf-8")
        shown = len(made.path.overview) if made.path else 0
        spent = time.perf_counter() - begun
        print(f"{name}: {len(text) / 1e6:.1f} MB in {spent:.1f} s; {shown} of {SAMPLES} points in the first view")
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
    from browser import browser, executable

    if executable() is None:
        print("no chromium is installed: not turned")
        return
    with browser() as chromium:
        for name, file in pages.items():
            with chromium.page(file, 1280) as page:
                page.settled()
                speeds = [page.run(TURN.replace("ZOOM", str(zoom))) for zoom in (1, 8, 40)]
                print(f"{name}: {', '.join(f'{speed:.0f}' for speed in speeds)} pictures/s at zoom 1, 8, 40")


if __name__ == "__main__":
    main()

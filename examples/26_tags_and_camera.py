"""Pages of tags for a camera, and how far away the camera of an OpenCV file reads them."""

import tempfile
from pathlib import Path

import cablewright as cw
from cablewright.apps.pictures.tag_sheet import pages_of, svg_of
from cablewright.calibration.sightings.detection import MIN_SIDE
from cablewright.calibration.sightings.layout import load_layout

layout = load_layout("examples/tags.toml")
phone = cw.camera("examples/phone.yml").camera
with tempfile.TemporaryDirectory() as folder:
    for at, page in enumerate(pages_of(layout), 1):
        (Path(folder) / f"page-{at}.svg").write_text(svg_of(page), encoding="utf-8")
    print(f"{len(list(Path(folder).iterdir()))} pages of A4")

for tag in layout.tags:
    print(f"tag {tag.number}: {1e3 * tag.size:.0f} mm, on {tag.on}")
largest = max(tag.size for tag in layout.tags)
print(f"the largest tag is read up to: {largest * phone.focal[0] / MIN_SIDE:.2f} m")

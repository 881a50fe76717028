"""Tags for a camera, and how far away the camera of an OpenCV file reads the largest one."""

import tomllib
from pathlib import Path

import cablewright as cw

layout = cw.TagLayout.model_validate(tomllib.loads(Path("examples/tags.toml").read_text("utf-8")))
phone = cw.camera("examples/phone.yml").camera
for tag in layout.tags:
    print(f"tag {tag.number}: {1e3 * tag.size:.0f} mm, on {tag.on}")
largest = max(tag.size for tag in layout.tags)
pixels = 25.0  # of a tag's side, from which on it is read
print(f"the largest tag is read up to: {largest * phone.focal[0] / pixels:.2f} m")

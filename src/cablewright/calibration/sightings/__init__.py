"""Camera pictures of tags: layout, camera and lens, detection, and the poses and positions that follow."""

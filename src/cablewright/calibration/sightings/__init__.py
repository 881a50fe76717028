"""Tags in pictures: their layout, the camera and its lens, detection, and what pictures say of poses and places."""

"""What is drawn in a browser: one description of a scene, and the viewer that draws it."""

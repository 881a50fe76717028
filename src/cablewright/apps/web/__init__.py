"""3-D scenes for the browser: the description of a scene, and the viewer that draws it."""

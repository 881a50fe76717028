"""Matplotlib pictures of results. Functions that draw are called within `style.drawing`."""

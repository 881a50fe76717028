"""Exit points, axes and walls from a total station's shots at markers."""

"""Exit points, sheave axes and walls from a total station's measurements of markers."""

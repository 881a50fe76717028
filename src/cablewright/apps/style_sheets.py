"""Settings of pictures from a style sheet of matplotlib, or by name."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl

from cablewright.foundation.errors import InputError, UnknownName, suggestion


def settings_of(style: str | Path | Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of a style sheet, or those that are given by name. Raises `InputError`."""
    if isinstance(style, Mapping):
        unknown = [key for key in style if key not in mpl.rcParams]
        if unknown:
            raise UnknownName("setting of a style", unknown[0], mpl.rcParams)
        return dict(style)
    file = Path(style)
    try:
        lines = [line.split("#", 1)[0].partition(":")[0].strip() for line in file.read_text("utf-8").splitlines()]
    except (OSError, UnicodeDecodeError) as reason:
        raise InputError(f"style = {str(file)!r}: cannot be read: {getattr(reason, 'strerror', reason)}") from None
    for number, key in enumerate(lines, 1):
        if key and key not in mpl.rcParams:
            raise InputError(f"{file}: line {number}: unknown setting {key!r}; {suggestion(key, mpl.rcParams)}")
    found: Any = mpl.rc_params_from_file(str(file), use_default_template=False)
    for number, key in enumerate(lines, 1):
        if key and key not in found:
            raise InputError(f"{file}: line {number}: {key}: the value is not one that matplotlib allows")
    return dict(found)

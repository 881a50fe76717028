"""Messages of ROS 2 with all their fields, by rosbags' definitions of the types."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

_TEXT: Final = "string"


def filled(classes: Mapping[str, Any], store: Any, kind: str, given: Mapping[str, Any], *, lists: bool = False) -> Any:
    """Return a message of the type *kind* with the *given* fields, and zeros for all others.

    *classes*: classes of the messages, by type. *store*: rosbags' store of types. *lists*: numbers in lists, not in
    arrays.
    """

    def value(field: Any, content: Any) -> Any:
        node, of = field
        if node.name == "NAME":
            return filled(classes, store, of, content or {}, lists=lists)
        if node.name == "BASE":
            return content if content is not None else {_TEXT: "", "bool": False}.get(of[0], 0)
        element, count = of
        if element[0].name == "BASE" and element[1][0] != _TEXT:
            name = element[1][0]
            made = np.zeros(count, dtype=name) if content is None else np.asarray(content, dtype=name)
            return made.tolist() if lists else made
        return [value(element, each) for each in content or ()]

    return classes[kind](**{name: value(field, given.get(name)) for name, field in store.fielddefs[kind][1]})

"""Reader of XML from any source: limits of size, depth and number of elements, and no entities.

A document type is read over, as CASPR's files have one; where it is another file, that is not read. What could make a
small file large is rejected: entities, and default values of attributes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final
from xml.parsers import expat

from cablewright.foundation.errors import InputError, suggestion
from cablewright.foundation.toml_input import read_bytes
from cablewright.foundation.units import NUMBER
from cablewright.foundation.validation import shown

MAX_BYTES: Final = 4 << 20
MAX_DEPTH: Final = 32
MAX_ELEMENTS: Final = 20_000

TEXT: Final = "#text"
"""Key of an element's text among what was read of it."""

_NUMBER = re.compile(NUMBER, re.ASCII)


@dataclass
class Element:
    """An XML element: its tag, attributes, own text and children.

    ``place``: file and line, for messages. It remembers which of its attributes were read, and whether its text was, so
    that `unread` can list the unused ones.
    """

    tag: str
    attributes: dict[str, str]
    place: str
    children: list[Element] = field(default_factory=list)
    text: str = ""
    read: set[str] = field(default_factory=set)

    def all(self, tag: str) -> Iterator[Element]:
        """Yield the child elements with the given XML tag."""
        return (child for child in self.children if child.tag == tag)

    def one(self, tag: str) -> Element:
        """Return the only child element with the given tag. Raises `InputError` for none and for several."""
        found = self.maybe(tag)
        if found is None:
            raise InputError(f"{self.place}: <{self.tag}> has no <{tag}>")
        return found

    def maybe(self, tag: str) -> Element | None:
        """Return the only child element with the given tag, or None. Raises `InputError` for several."""
        found = list(self.all(tag))
        if len(found) > 1:
            raise InputError(f"{found[1].place}: a second <{tag}> in <{self.tag}>; one is allowed")
        return found[0] if found else None

    def attribute(self, name: str) -> str:
        """Return an XML attribute as text. Raises `InputError` if it is missing."""
        if name not in self.attributes:
            near = suggestion(name, self.attributes) if self.attributes else "it has none"
            raise InputError(f"{self.place}: <{self.tag}> has no attribute {name!r}; {near}")
        self.read.add(name)
        return self.attributes[name]

    def number(self, name: str, default: float | None = None, *, least: float = -math.inf) -> float:
        """Return the finite number in an attribute, or *default* where it is missing.

        Raises `InputError`, for a number below *least* too.
        """
        if default is not None and name not in self.attributes:
            return default
        return finite(self.attribute(name), f"{self.place}: {self.tag}.{name}", least)

    def numbers(self, count: int, least: float = -math.inf) -> tuple[float, ...]:
        """Return *count* finite numbers of an XML attribute. Raises `InputError`, also for one below *least*."""
        self.read.add(TEXT)
        words = self.text.split()
        if len(words) != count:
            raise InputError(f"{self.place}: <{self.tag}> = {shown(self.text.strip())}: must be {count} numbers")
        return tuple(finite(word, f"{self.place}: <{self.tag}>", least) for word in words)

    def skip(self, *names: str) -> None:
        """Mark attributes as read that have no counterpart in a robot."""
        self.read.update(names)

    def unread(self, within: str = "") -> Iterator[str]:
        """Yield the unread parts of this element and its children, as dotted paths, each once."""
        path = f"{within}.{self.tag}" if within else self.tag
        found = {f"{path}.{name}": None for name in self.attributes if name not in self.read}
        if self.text and TEXT not in self.read:
            found[path] = None
        for child in self.children:
            found |= dict.fromkeys(child.unread(path))
        yield from found


def finite(text: str, place: str, least: float = -math.inf) -> float:
    """Return the finite number in a text. Raises `InputError`, also for NaN, infinity and a number with a unit."""
    number = number_or_none(text)
    if number is None:
        raise InputError(f"{place} = {shown(text)}: must be a finite number without a unit")
    if number < least:
        raise InputError(f"{place} = {shown(text)}: must be at least {least:g}")
    return number


def number_or_none(text: str) -> float | None:
    """Return the finite number in a text, or None."""
    word = text.strip()
    number = float(word) if _NUMBER.fullmatch(word) else math.nan
    return number if math.isfinite(number) else None


def whole(text: str, place: str) -> int:
    """Return the whole number, 1 or more, in a text. Raises `InputError`."""
    number = finite(text, place)
    if number != int(number) or number < 1:
        raise InputError(f"{place} = {text[:60]!r}: must be a whole number, 1 or more")
    return int(number)


def read_xml(path: Path, roots: Sequence[str]) -> Element:
    """Return the root element of a file; ``roots`` are the tags that it may have.

    Raises `InputError` for a file that cannot be read, is not well-formed, has entities or is larger than the limits.
    """
    root = parse_xml(read_bytes(path, MAX_BYTES, "robot in XML"), str(path))
    if root.tag not in roots:
        raise InputError(f"{path}: root element <{root.tag[:60]}>: must be <{'> or <'.join(roots)}>")
    return root


def parse_xml(data: bytes, origin: str) -> Element:
    """Return the root element of XML *data*; *origin* names it in messages. Raises `InputError`."""
    tree = _Tree(origin)
    try:
        tree.parser.Parse(data, True)
    except expat.ExpatError as error:
        why = expat.ErrorString(error.code)
        raise InputError(f"{origin}, line {error.lineno}: not well-formed XML: {why}") from None
    except (LookupError, ValueError):  # an encoding that Python lacks, or one with several bytes a letter
        raise InputError(f"{origin}: its XML declaration names an unknown encoding; save it as UTF-8") from None
    assert tree.root is not None  # without a root it is not well-formed
    return tree.root


class _Tree:
    """Handlers that build the elements, and reject what is dangerous as soon as it is met."""

    def __init__(self, origin: str) -> None:
        self.origin = origin
        self.root: Element | None = None
        self.open: list[Element] = []
        self.count = 0
        self.parser = parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._text
        parser.EntityDeclHandler = self._entity
        parser.AttlistDeclHandler = self._attlist
        parser.SkippedEntityHandler = self._skipped
        parser.ExternalEntityRefHandler = self._external

    @property
    def place(self) -> str:
        return f"{self.origin}, line {self.parser.CurrentLineNumber}"

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self.count += 1
        if self.count > MAX_ELEMENTS:
            raise InputError(f"{self.place}: more than {MAX_ELEMENTS} elements, the most a robot may have")
        if len(self.open) == MAX_DEPTH:
            raise InputError(f"{self.place}: nested deeper than {MAX_DEPTH} levels, the most a robot may be")
        element = Element(tag, attributes, self.place)
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def _end(self, _tag: str) -> None:
        self.open.pop()

    def _text(self, text: str) -> None:
        if not text.isspace():
            self.open[-1].text += text

    def _entity(self, name: str, *_of_it: object) -> None:
        raise InputError(f"{self.place}: declares the entity {name[:60]!r}; entities are not supported")

    def _attlist(self, tag: str, name: str, _kind: str, default: str | None, _required: int) -> None:
        if default is not None:
            where = f"{tag[:60]}.{name[:60]}"
            raise InputError(f"{self.place}: a default value of the attribute {where}; write it out in the elements")

    def _skipped(self, name: str, _is_parameter: int) -> None:
        raise InputError(f"{self.place}: uses the entity {name[:60]!r}; entities are not supported")

    def _external(self, *_of_it: object) -> int:
        raise InputError(f"{self.place}: refers to another file; nothing else is read")

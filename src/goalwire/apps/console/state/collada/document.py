"""A COLLADA document: its elements by their ids, and the numbers in its texts."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from goalwire import xml_tree
from goalwire.errors import peer_text
from goalwire.xml_tree import Element, XmlError

Floats: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]

MOST_MEMORY = 256 << 20
"""The most bytes that the tree of elements may take: a small file of small elements makes a large tree."""
MOST_SECONDS = 20.0
"""The most seconds of processor time that a file may take. Elements may refer to one another many times: this
limits what no other limit does.
"""
_PIECE = 1 << 16
_SPACE = re.compile(r'\s')


class ColladaError(ValueError):
    """The file cannot be shown; the message is one line that says why."""


class Document:
    """The elements of a COLLADA file. Raises ColladaError if the text is not COLLADA."""

    def __init__(self, data: bytes) -> None:
        self._began = time.thread_time()
        try:
            self.root = xml_tree.read(data, most_memory=MOST_MEMORY)
        except XmlError as error:
            raise ColladaError(f'it cannot be read as XML: {error}') from None
        if self.root.tag != 'COLLADA':
            raise ColladaError(f'it is not COLLADA: it begins with <{peer_text(self.root.tag, 40)}>')
        self._arrays: dict[str, Floats] = {}
        self._by_id: dict[str, Element] = {}
        for element in elements_of(self.root):
            if (name := element.attributes.get('id')) is not None:
                self._by_id.setdefault(name, element)

    def find(self, url: str, tag: str) -> Element | None:
        """Return the element that '#id', or a bare id, names; None if there is none with this tag.

        Raises ColladaError if the file has taken too long.
        """
        if time.thread_time() - self._began > MOST_SECONDS:
            raise ColladaError(f'it takes more than {MOST_SECONDS:.0f} s to read')
        found = self._by_id.get(url.removeprefix('#'))
        return found if found is not None and found.tag == tag else None

    def get(self, url: str, tag: str) -> Element:
        """Return the element that '#id' names. Raises ColladaError if there is none with this tag."""
        found = self.find(url, tag)
        if found is None:
            raise ColladaError(
                f"it refers to <{tag} id='{peer_text(url.removeprefix('#'), 60)}'>, which it lacks"
            )
        return found

    def array(self, url: str) -> Floats:
        """Return the numbers of the <float_array> that '#id' names. Raises ColladaError."""
        if url not in self._arrays:
            self._arrays[url] = floats(self.get(url, 'float_array'))
        return self._arrays[url]


def elements_of(root: Element) -> Iterator[Element]:
    """Yield an element and all elements inside it. Fast also if they lie deep in one another."""
    waiting = [root]
    while waiting:
        element = waiting.pop()
        yield element
        waiting += reversed(element.children)


def inner(element: Element | None, *tags: str) -> Element | None:
    """Return the first element on a way of tags; None if the way ends before."""
    for tag in tags:
        if element is None:
            return None
        element = element.find(tag)
    return element


def floats(element: Element) -> Floats:
    """Return the numbers of an element's text. Raises ColladaError for texts that are not finite numbers."""
    values = _numbers(element, np.float64)
    if not np.isfinite(values).all():
        raise ColladaError(f'<{element.tag}> of line {element.line} has a number that is not finite')
    return values


def integers(element: Element) -> Integers:
    """Return the whole numbers of an element's text. Raises ColladaError for other texts."""
    return _numbers(element, np.int64)


def integer(element: Element, attribute: str, default: int) -> int:
    """Return a whole number in an attribute. Raises ColladaError for other texts."""
    text = element.attributes.get(attribute)
    if text is None:
        return default
    if not re.fullmatch(r'\s*[0-9]{1,9}\s*', text, re.ASCII):
        raise ColladaError(f'<{element.tag}> of line {element.line} has no number as its {attribute}')
    return int(text)


def _numbers(element: Element, kind: type[Any]) -> NDArray[Any]:
    """A long text is read in pieces, between which other threads run."""
    text, pieces, begin = element.text, [np.empty(0, kind)], 0
    try:
        while begin < len(text):
            space = _SPACE.search(text, begin + _PIECE)
            end = len(text) if space is None else space.start()
            pieces.append(np.array(text[begin:end].split(), dtype=kind))
            begin = end
    except (ValueError, OverflowError):
        raise ColladaError(
            f'<{element.tag}> of line {element.line} has a text that is not a number'
        ) from None
    return np.concatenate(pieces)

"""The settings in a configuration file, and the names of those without effect here."""

from __future__ import annotations

from collections.abc import Mapping

from goalwire.errors import TransportError
from goalwire.files import read_regular, show
from goalwire.xml_tree import Element, XmlError, read

LARGEST_FILE = 1_000_000
"""The largest file in bytes. Real files have some kB."""
_LONGEST_QUOTED = 80
DISCOVERY_SERVER = 'a discovery server'
"""Stands in the reported name of each setting that asks for a discovery server."""


class Findings:
    """The settings read so far. Later ones replace earlier ones; lists grow."""

    def __init__(self, origin: str) -> None:
        """`origin` is the variable that names the configuration."""
        self.origin = origin
        self.values: dict[str, object] = {}
        """Fields of `goalwire.rtps.io.settings.Settings`."""
        self.ports: dict[str, int] = {}
        """Fields of `Ports`."""
        self.peers: list[str] = []
        self.interfaces: list[str] = []
        self.excluded: list[str] = []
        self.ignored: dict[str, None] = {}
        """Settings that have no effect here, in the order in which they were found."""

    def ignore(self, name: str) -> None:
        """Take note of a setting that has no effect here."""
        self.ignored[name] = None

    def error(self, element: Element, text: str, expected: str) -> TransportError:
        """Return the error for a setting that cannot be understood."""
        quoted = text if len(text) <= _LONGEST_QUOTED else f'{text[:_LONGEST_QUOTED]}…'
        return TransportError(
            f'{self.origin}: line {element.line}: <{show(element.tag)}> is {quoted!r}; write {expected}'
        )

    def number(self, element: Element, text: str, least: int, most: int) -> int:
        """Return a whole number within a range; raises TransportError."""
        try:
            number = int(text) if len(text) < 20 else most + 1
        except ValueError:
            number = most + 1
        if not least <= number <= most:
            raise self.error(element, text, f'a whole number from {least} to {most}')
        return number

    def boolean(self, element: Element, text: str) -> bool:
        """Return the value of a setting that is true or false; raises TransportError."""
        found = _BOOLEANS.get(text.lower())
        if found is None:
            raise self.error(element, text, 'true or false')
        return found

    def parse(self, text: str | bytes) -> Element:
        """Return the outermost element of a document; raises TransportError."""
        try:
            return read(text)
        except XmlError as error:
            raise TransportError(f'{self.origin} cannot be read as XML: {error}') from None

    def read_file(self, path: str) -> bytes:
        """Return the content of a file; raises TransportError."""
        try:
            return read_regular(path, LARGEST_FILE)
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else str(error)
            raise TransportError(f'{self.origin}: the file {show(path)!r} cannot be read: {reason}') from None


_BOOLEANS: Mapping[str, bool] = {
    'true': True,
    '1': True,
    'yes': True,
    'false': False,
    '0': False,
    'no': False,
}


def within(element: Element, *tags: str) -> Element | None:
    """Return the element at a path of tags, whose case does not matter; None if there is none."""
    for tag in tags:
        found = next((child for child in element.children if local_name(child) == tag.lower()), None)
        if found is None:
            return None
        element = found
    return element


def local_name(element: Element) -> str:
    """Return a tag without its namespace, in small letters."""
    return element.tag.rpartition(':')[2].lower()

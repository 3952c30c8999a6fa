"""Reads XML that others wrote: package.xml, launch files, URDF.

Entities of XML can make a short document huge, or read files. Entities are declared in a document type, which
none of these files needs, so a document type is refused. Elements know their line numbers, for error texts.

Why not defusedxml: it would be a dependency for the sake of one handler. Its ElementTree has no line numbers,
and its import takes several times as long, in programs that only read one package.xml.
"""

from __future__ import annotations

from collections.abc import Iterator
from xml.parsers import expat

DEEPEST = 200
"""The largest depth of nested elements: functions that walk a tree are recursive, and Python limits
recursion.
"""


class XmlError(ValueError):
    """The text is not XML, or contains something that is refused; `line` says where, `problem` says what."""

    def __init__(self, problem: str, line: int, column: int) -> None:
        super().__init__(f'{problem}: line {line}, column {column}')
        self.problem = problem
        self.line = line


class Element:
    """An element: its tag, attributes, child elements and text."""

    __slots__ = ('_text', 'attributes', 'children', 'line', 'tag', 'text_line')

    def __init__(self, tag: str, attributes: dict[str, str], line: int) -> None:
        self.tag = tag
        self.attributes = attributes
        self.children: list[Element] = []
        self.line = line
        self.text_line: int | None = None
        """The line of the first character of the text that is not a space; None if there is none."""
        self._text: list[str] = []

    @property
    def text(self) -> str:
        """The text that is directly in this element, outside its children."""
        return ''.join(self._text)

    def add_text(self, characters: str, line: int) -> None:
        """Append characters to the element's text."""
        if self.text_line is None and not characters.isspace():
            self.text_line = line
        self._text.append(characters)

    def find(self, tag: str) -> Element | None:
        """Return the first child with a tag; None if there is none."""
        return next((child for child in self.children if child.tag == tag), None)

    def findall(self, tag: str) -> list[Element]:
        """Return the children with a tag, in order."""
        return [child for child in self.children if child.tag == tag]

    def walk(self) -> Iterator[Element]:
        """Yield this element and all elements inside it, in the order of the document."""
        yield self
        for child in self.children:
            yield from child.walk()


_UNCLOSED = frozenset(
    expat.errors.codes[problem]
    for problem in (expat.errors.XML_ERROR_TAG_MISMATCH, expat.errors.XML_ERROR_NO_ELEMENTS)
)
"""expat's codes of the errors that an unclosed element causes."""


_ELEMENT_BYTES, _ATTRIBUTE_BYTES, _TEXT_BYTES = 400, 200, 80
"""About how much memory an element, an attribute and a piece of text take here beside their characters."""


def read(data: bytes | str, most_memory: int | None = None) -> Element:
    """Parse a document and return its outermost element. Raises XmlError.

    `most_memory` limits, roughly, the bytes that the elements take beside their characters: small elements
    take a hundred times their bytes in the document.
    """
    parser = expat.ParserCreate()
    root = Element('', {}, 0)
    open_elements = [root]
    memory = 0

    def refused(problem: str) -> XmlError:
        return XmlError(problem, parser.CurrentLineNumber, parser.CurrentColumnNumber)

    def take(size: int) -> None:
        nonlocal memory
        memory += size
        if most_memory is not None and memory > most_memory:
            raise refused(f'its elements take more than {most_memory >> 20} MB of memory')

    def begin(tag: str, attributes: dict[str, str]) -> None:
        take(_ELEMENT_BYTES + _ATTRIBUTE_BYTES * len(attributes))
        if len(open_elements) > DEEPEST:
            raise refused(f'more than {DEEPEST} elements lie in one another')
        element = Element(tag, attributes, parser.CurrentLineNumber)
        open_elements[-1].children.append(element)
        open_elements.append(element)

    def end(_: str) -> None:
        open_elements.pop()

    def text(characters: str) -> None:
        take(_TEXT_BYTES)
        open_elements[-1].add_text(characters, parser.CurrentLineNumber)

    def doctype(*_: object) -> None:
        raise refused('it declares a document type (<!DOCTYPE>), which is not read')

    parser.StartElementHandler, parser.EndElementHandler = begin, end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = text, doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        problem = expat.errors.messages.get(error.code, str(error))
        if len(open_elements) > 1 and error.code in _UNCLOSED:
            last = open_elements[-1]
            problem += f'; <{last.tag}> of line {last.line} is open: write </{last.tag}> where it ends'
        raise XmlError(problem, error.lineno, error.offset) from None
    except (ValueError, LookupError) as error:  # from Python's codecs, which expat calls
        if isinstance(error, XmlError):
            raise
        raise refused(
            f'it is in an encoding that XML readers do not know: {error}; save it as UTF-8'
        ) from None
    return root.children[0]

"""Markdown pages as the tests of the documents read them: fenced blocks and links."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
DOCS = ROOT / 'docs'
PAGES = [ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *sorted(DOCS.rglob('*.md'))]

_FENCE = re.compile(r'^```(\w*)(?: +title=(\S+))?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
_LINK = re.compile(r'\]\(([^)\s]+)\)')


class Block(NamedTuple):
    """One fenced block; `title` is the file that it is, '' if it is none: ```python title=lamp.py."""

    language: str
    title: str
    text: str
    line: int


def name_of(page: Path) -> str:
    """How a page is called in the output of pytest."""
    return page.relative_to(ROOT).as_posix()


def blocks(page: Path) -> Iterator[Block]:
    """Yield a page's fenced blocks, in order."""
    text = page.read_text(encoding='utf-8')
    for match in _FENCE.finditer(text):
        language, title, content = match.groups(default='')
        yield Block(language, title, content, text.count('\n', 0, match.start()) + 1)


def links(page: Path) -> list[str]:
    """Return the targets of a page's links, code aside."""
    text = _FENCE.sub('', page.read_text(encoding='utf-8'))
    return _LINK.findall(re.sub(r'`[^`\n]*`', '', text))


def anchors(page: Path) -> set[str]:
    """Return what a link to a heading of this page may name, spelled as GitHub does."""
    text = _FENCE.sub('', page.read_text(encoding='utf-8'))
    headings = re.findall(r'^#+ (.+)$', text, re.MULTILINE)
    return {re.sub(r'[^\w\- ]', '', heading.lower()).replace(' ', '-') for heading in headings}


def rows(page: Path, header: str) -> list[list[str]]:
    """Return the cells of the table whose first heading is `header`; AssertionError if there is none."""
    lines = iter(page.read_text(encoding='utf-8').splitlines())
    assert any(line.startswith(f'| {header} |') for line in lines), f'{name_of(page)}: no table of {header}'
    next(lines)
    found = []
    for line in lines:
        if not line.startswith('|'):
            break
        found.append([cell.strip() for cell in line[1:-1].split('|')])
    return found

"""The pages of docs/ as Sphinx reads them: titles of blocks, links out of docs/, tables of contents."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / 'docs'
MOVED = {
    ROOT / 'CONTRIBUTING.md': 'contributing.md',
    ROOT / 'CHANGELOG.md': 'changelog.md',
    ROOT / 'README.md': 'readme.md',
}
"""Pages that lie beside docs/, and where they lie on the site."""

_FENCE = re.compile(r'^```(\w+) +title=(\S+)$', re.MULTILINE)
_LINK = re.compile(r'(?<=\]\()(?!https?:)([^)\s#]+)')
_BLOCKS = re.compile(r'(^```.*?^```$)', re.MULTILINE | re.DOTALL)


class Pages:
    """Writes the pages into a folder. What a page links to in the source becomes a page, too."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._sources: set[Path] = set()

    def write(self) -> None:
        """Copy everything of docs/, and the pages beside it."""
        for file in sorted(DOCS.rglob('*')):
            if file.is_dir():
                continue
            target = self._folder / file.relative_to(DOCS)
            target.parent.mkdir(parents=True, exist_ok=True)
            if file.suffix == '.md':
                target.write_text(self._converted(file), encoding='utf-8')
            else:
                shutil.copy(file, target)
        for file, name in MOVED.items():
            (self._folder / name).write_text(self._converted(file), encoding='utf-8')
        for file in sorted(self._sources):
            self._write_source(file)

    def _converted(self, file: Path) -> str:
        text = file.read_text(encoding='utf-8')
        parts = _BLOCKS.split(text)
        for index, part in enumerate(parts):
            if part.startswith('```'):
                parts[index] = _FENCE.sub(r'```{code-block} \1\n:caption: \2\n', part)
            else:
                parts[index] = _LINK.sub(lambda found: self._site_link(file, found[1]), part)
        return ''.join(parts) + contents(file)

    def _site_link(self, page: Path, link: str) -> str:
        """Return a link as it is on the site, where only docs/ keeps its places."""
        target = (page.parent / link).resolve()
        if not target.is_relative_to(DOCS) and target not in MOVED:
            self._sources |= {target, *_files_of(target)}
        return Path(os.path.relpath(self._place(target), self._place(page).parent)).as_posix()

    def _place(self, file: Path) -> Path:
        """Return where a file lies on the site, from its root."""
        if file in MOVED:
            return Path(MOVED[file])
        if file.is_relative_to(DOCS):
            return file.relative_to(DOCS)
        return Path('sources', f'{file.relative_to(ROOT).as_posix()}.md')

    def _write_source(self, file: Path) -> None:
        target = self._folder / self._place(file)
        target.parent.mkdir(parents=True, exist_ok=True)
        name = file.relative_to(ROOT).as_posix()
        if file.is_dir():
            text = ''.join(f'- [{each.name}]({file.name}/{each.name}.md)\n' for each in _files_of(file))
        else:
            text = f'````python\n{file.read_text(encoding="utf-8")}````\n'
        target.write_text(f'---\norphan: true\n---\n# {name}\n\n{text}', encoding='utf-8')


def _files_of(folder: Path) -> list[Path]:
    """Return the programs in a folder; none for a file."""
    return sorted(folder.glob('*.py'))


def contents(file: Path) -> str:
    """Return a page's tables of contents: one a section in the index, the decisions in the architecture."""
    text = file.read_text(encoding='utf-8')
    if file == DOCS / 'index.md':
        sections = re.split(r'^\*\*(.+)\*\*$', text, flags=re.MULTILINE)[1:]
        named = zip(sections[::2], sections[1::2], strict=True)
        parts = [_toctree(title, _pages(file, body)) for title, body in named]
        rest = ['api/index', 'commands/index', 'changelog', 'readme']
        parts.append(_toctree('Reference of names', rest))
        return ''.join(parts)
    if file == DOCS / 'explanation' / 'architecture.md':
        return _toctree('', [page for page in _pages(file, text) if '/adr/' in page])
    return ''


def descriptions() -> dict[str, str]:
    """Return what docs/index.md says about each page that it links to, by the page's name."""
    found: dict[str, str] = {}
    index = DOCS / 'index.md'
    for item in re.findall(r'^- (.+(?:\n  .+)*)', index.read_text(encoding='utf-8'), re.MULTILINE):
        links = re.findall(r'\[([^]]+)\]\(([^)\s#]+)\.md\)', item)
        for title, name in links:
            about = item.rpartition('): ')[2] if len(links) == 1 else ''
            found[name.removeprefix('../').lower()] = ' '.join(f'{title} {about}'.split())
    return found


def _pages(file: Path, text: str) -> list[str]:
    """Return the pages that a text links to, each once, without their endings."""
    found: dict[str, None] = {}
    for link in re.findall(r'\]\((?!http)([^)\s#]+\.md)', text):
        target = (file.parent / link).resolve()
        name = MOVED.get(target) or Path(os.path.relpath(target, file.parent)).as_posix()
        found[name.removesuffix('.md')] = None
    return list(found)


def _toctree(caption: str, names: list[str]) -> str:
    option = f':caption: {caption}\n' if caption else ''
    return '\n```{toctree}\n:hidden:\n' + option + '\n' + '\n'.join(names) + '\n```\n'

"""The pages that the site is built from. The whole site takes minutes, and is built in make long."""

from __future__ import annotations

from pathlib import Path

from tools.site.pages import Pages


def test_a_folder_that_a_page_links_to_lists_its_programs(tmp_path: Path) -> None:
    Pages(tmp_path).write()
    folder = (tmp_path / 'sources' / 'examples' / 'fleet_missions.md').read_text(encoding='utf-8')
    assert '- [worker.py](fleet_missions/worker.py.md)' in folder
    worker = (tmp_path / 'sources' / 'examples' / 'fleet_missions' / 'worker.py.md').read_text(
        encoding='utf-8'
    )
    assert worker.startswith('---\norphan: true\n---\n# examples/fleet_missions/worker.py\n\n````python\n')


def test_every_page_of_docs_is_on_the_site(tmp_path: Path) -> None:
    Pages(tmp_path).write()
    docs = Path(__file__).parents[2] / 'docs'
    here = {file.relative_to(docs) for file in docs.rglob('*.md')}
    assert here <= {file.relative_to(tmp_path) for file in tmp_path.rglob('*.md')}

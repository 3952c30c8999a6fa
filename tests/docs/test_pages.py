"""The documents do what they say: every file, program, terminal and link that a page shows."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.forking import ForkServer
from helpers.isolation import NETWORK, isolated_env
from helpers.markdown import DOCS, PAGES, anchors, blocks, links, name_of
from helpers.terminals import play

_OF_PROGRAMS = ('goalwire.apps.cli.main', 'goalwire.aio', 'goalwire.observe', 'rclpy', 'rclpy.action')


def _has_programs(page: Path) -> bool:
    return any(block.language in {'console', 'python'} for block in blocks(page))


@pytest.fixture(scope='module')
def programs() -> Iterator[ForkServer]:
    """The process that forks the programs and commands of all pages: it has imported what most import.

    Pages share no more than the modules. Each program is a process of its own, in its page's world.
    """
    with ForkServer(_OF_PROGRAMS, isolated_env(NETWORK)) as server:
        yield server


@pytest.mark.slow
@pytest.mark.parametrize('page', [page for page in PAGES if _has_programs(page)], ids=name_of)
def test_a_page_does_what_it_shows(page: Path, programs: ForkServer, tmp_path: Path) -> None:
    play(page, tmp_path, programs)


@pytest.mark.parametrize('page', PAGES, ids=name_of)
def test_every_link_leads_somewhere(page: Path) -> None:
    for link in links(page):
        if link.startswith(('https://', 'http://')):
            continue
        path, _, heading = link.partition('#')
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f'{name_of(page)}: {link} leads nowhere'
        assert not heading or heading in anchors(target), f'{name_of(page)}: no heading for {link}'


@pytest.mark.parametrize('page', PAGES, ids=name_of)
def test_every_python_block_is_python(page: Path) -> None:
    for block in blocks(page):
        if block.language == 'python':
            compile(block.text, f'{name_of(page)}:{block.line}', 'exec')


def test_every_page_is_reached_from_the_index() -> None:
    index = DOCS / 'index.md'
    reached = {(index.parent / link.partition('#')[0]).resolve() for link in links(index)}
    missing = [name_of(page) for page in PAGES if page.parent.name != 'adr' and page not in {index, *reached}]
    assert missing == [name_of(PAGES[0])]  # the README leads to the index, not the other way round


def test_every_decision_is_reached_from_the_architecture() -> None:
    page = DOCS / 'explanation' / 'architecture.md'
    listed = {(page.parent / link.partition('#')[0]).resolve() for link in links(page)}
    assert [each.name for each in sorted((DOCS / 'adr').glob('*.md')) if each not in listed] == []

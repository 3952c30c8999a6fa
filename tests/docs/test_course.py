"""The pages of the course: the chapter's programs are the ones in examples, and the diagrams are traces."""

from __future__ import annotations

import re

import pytest
from helpers.markdown import DOCS, ROOT, blocks

COURSE = DOCS / 'course'


@pytest.mark.parametrize('page', ['services.md', 'actions.md'])
def test_the_programs_on_the_pages_are_those_of_the_examples(page: str) -> None:
    shown = {block.title: block.text for block in blocks(COURSE / page) if block.title}
    assert shown
    for title, shown_text in shown.items():
        home = ROOT / ('robot' if '/' in title else 'examples/course') / title
        text_there = home.read_text(encoding='utf-8')
        if title.endswith('.py'):  # its head says what had to change: a page of its own does that here
            text_there = re.sub(r'\A(?:#.*\n)+', '', text_there)
        assert shown_text == text_there, f'{page}: {title}'


@pytest.mark.slow
def test_the_diagrams_show_what_the_programs_say_today() -> None:
    from tools.course_trace import pictures

    for file, text in pictures().items():
        assert file.read_text(encoding='utf-8') == text, 'run: python -m tools.course_trace'

"""The pages of the course: the chapter's programs are the ones in examples, and the diagrams are traces."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from helpers.isolation import NETWORK, isolated_env
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


@pytest.mark.long
@pytest.mark.slow
def test_the_cells_of_the_notebook_print_what_it_shows(tmp_path: Path) -> None:
    pytest.importorskip('ipykernel')
    from helpers.notebooks import Notebook

    book = json.loads((COURSE / 'services-and-actions.ipynb').read_text(encoding='utf-8'))
    cells = [cell for cell in book['cells'] if cell['cell_type'] == 'code']
    assert len(cells) > 5
    with Notebook(tmp_path, isolated_env(NETWORK)) as notebook:
        for cell in cells:
            shown = ''.join(line for output in cell['outputs'] for line in output['text'])
            assert notebook.run(''.join(cell['source'])) == shown, cell['id']

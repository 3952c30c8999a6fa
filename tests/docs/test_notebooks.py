"""The page about notebooks: its cells, run by a real kernel, show what the page shows."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from helpers.isolation import NETWORK, isolated_env
from helpers.markdown import DOCS, blocks

pytest.importorskip('ipykernel')
PAGE = DOCS / 'how-to' / 'notebooks.md'


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')
def test_the_cells_show_what_the_page_shows(tmp_path: Path) -> None:
    from helpers.notebooks import Notebook

    page = [block for block in blocks(PAGE) if block.language in {'py', 'text'}]
    assert page
    with Notebook(tmp_path, isolated_env(NETWORK)) as notebook:
        for cell, after in zip(page, [*page[1:], None], strict=True):
            if cell.language == 'text':
                continue
            shown = after.text.splitlines() if after is not None and after.language == 'text' else []
            interrupted_after = shown[0] if shown[1:] == ['KeyboardInterrupt'] else None
            output = notebook.run(cell.text, interrupted_after=interrupted_after)
            lines = [line.rstrip(': ') for line in output.splitlines() if '[WARN]' not in line]
            assert lines == shown, f'the cell of line {cell.line}'


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')
def test_a_complaint_does_not_break_a_line_that_a_cell_prints(tmp_path: Path) -> None:
    """print() writes a line and its end apart; the kernel may send a complaint between them."""
    from helpers.notebooks import Notebook

    cell = """
import sys
sys.stdout.write('calling'); sys.stdout.flush()
sys.stderr.write('[WARN] nobody\\n'); sys.stderr.flush()
sys.stdout.write('\\n'); sys.stdout.flush()
import threading
threading.Event().wait()
"""
    with Notebook(tmp_path, isolated_env(NETWORK)) as notebook:
        shown = notebook.run(cell, interrupted_after='calling')
    assert shown.splitlines() == ['calling', 'KeyboardInterrupt: ', '[WARN] nobody']

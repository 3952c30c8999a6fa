"""The files of execution lie as their page says: imports go up its table, never down."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from helpers.markdown import DOCS, rows

from goalwire import execution

FOLDER = Path(execution.__file__).parent
ROWS = {
    file: row
    for row, (_, files) in enumerate(rows(DOCS / 'explanation' / 'execution.md', 'idea'))
    for file in re.findall(r'`([a-z_/]+\.py)`', files)
}


def test_every_file_is_on_the_page() -> None:
    files = {file.relative_to(FOLDER).as_posix() for file in FOLDER.rglob('*.py')}
    assert {file for file in files if not file.endswith('__init__.py')} == set(ROWS)


def test_a_file_imports_from_rows_above_its_own_alone() -> None:
    seen = 0
    for file, row in ROWS.items():
        for node in ast.walk(ast.parse((FOLDER / file).read_text(encoding='utf-8'))):
            if isinstance(node, ast.ImportFrom) and (node.module or '').startswith('goalwire.execution.'):
                target = (node.module or '').removeprefix('goalwire.execution.').replace('.', '/')
                is_folder = (FOLDER / target).is_dir()
                for name in [f'{target}/{alias.name}' for alias in node.names] if is_folder else [target]:
                    assert ROWS[f'{name}.py'] <= row, f'{file} imports {name}.py, which stands below it'
                    seen += 1
    assert seen > len(ROWS)

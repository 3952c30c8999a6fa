"""Runs the tests of this folder, the long ones too, and writes what they have shown into reliability.md.

python tests/reliability/report.py [FILE …]: given evidence, nothing is run; later files replace earlier ones.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
PAGE = HERE.parents[1] / 'docs' / 'reference' / 'reliability.md'
BEGIN, END = '<!-- written by tests/reliability/report.py -->', '<!-- the end of it -->'
WIRES = ['memory', 'Zenoh', 'DDS']


def items() -> list[dict[str, Any]]:
    """Return what is to be proven."""
    found: list[dict[str, Any]] = tomllib.loads((HERE / 'items.toml').read_text(encoding='utf-8'))['item']
    return found


def collect(file: Path) -> None:
    """Run the tests."""
    subprocess.run(
        [sys.executable, '-m', 'pytest', '-q', '-n', '0', '--timeout=300', str(HERE)],
        env={**os.environ, 'GOALWIRE_EVIDENCE': str(file)},
        check=True,
    )


def read(files: Iterable[Path]) -> dict[tuple[int, str], dict[str, str]]:
    """Return the cells of each wire by item and faults."""
    found: dict[tuple[int, str], dict[str, str]] = {}
    for file in files:
        for line in file.read_text(encoding='utf-8').splitlines():
            row = json.loads(line)
            found.setdefault((row['item'], row['faults']), {})[row['wire']] = _cell(row)
    return found


def _cell(row: dict[str, Any]) -> str:
    ends = ', '.join(f'{number} {kind}' for kind, number in row['outcomes'].items())
    slowest = row['slowest']
    return ends if slowest is None else f'{ends}; {max(slowest, 0.01):.2f} s'


def what_is_proven() -> Iterator[str]:
    """Yield the table of the items and the tests that hold each."""
    yield '| item | what | tests |'
    yield '|---|---|---|'
    files = {f'reliability/{file.name}': _items_of(file) for file in sorted(HERE.glob('test_*.py'))}
    for item in items():
        here = [name for name, numbers in files.items() if item['number'] in numbers]
        tests = ', '.join(f'`{name}`' for name in [*here, *item['elsewhere']])
        yield f'| {item["number"]} | {item["what"]} | {tests} |'


def _items_of(file: Path) -> set[int]:
    """Return the items that a module's first words name: 'Items 9 and 10: …'."""
    title = file.read_text(encoding='utf-8').split(':')[0]
    return {int(word) for word in title.replace(',', ' ').split() if word.isdecimal()}


def what_was_shown(evidence: dict[tuple[int, str], dict[str, str]]) -> Iterator[str]:
    """Yield the table of the faults and of what became of everything."""
    yield f'| item and fault | {" | ".join(WIRES)} |'
    yield f'|---|{"---|" * len(WIRES)}'
    for (number, faults), cells in sorted(evidence.items(), key=lambda entry: entry[0][0]):
        yield f'| {number}: {faults} | {" | ".join(cells.get(wire, "") for wire in WIRES)} |'


def write(evidence: dict[tuple[int, str], dict[str, str]]) -> None:
    """Replace the tables of the page."""
    before, _, rest = PAGE.read_text(encoding='utf-8').partition(BEGIN)
    _, _, after = rest.partition(END)
    tables = '\n'.join([*what_is_proven(), '', *what_was_shown(evidence)])
    PAGE.write_text(f'{before}{BEGIN}\n\n{tables}\n\n{END}{after}', encoding='utf-8')


def main() -> None:
    files = [Path(name) for name in sys.argv[1:]]
    with tempfile.TemporaryDirectory() as folder:
        if not files:
            files = [Path(folder) / 'evidence.jsonl']
            collect(files[0])
        write(read(files))
    subprocess.run([sys.executable, '-m', 'tools.pictures'], cwd=HERE.parents[1], check=True)


if __name__ == '__main__':
    main()

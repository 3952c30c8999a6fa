"""The page about reliability has a row for each item, and names tests and faults that there are."""

from __future__ import annotations

import re
import tomllib
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

from helpers.markdown import DOCS, ROOT, rows

from goalwire.transport import faults
from goalwire.transport.faults import FailedCall, Fault, Kill, Point

PAGE = DOCS / 'reference' / 'reliability.md'
TESTS = ROOT / 'tests'


def items() -> list[dict[str, Any]]:
    text = (TESTS / 'reliability' / 'items.toml').read_text(encoding='utf-8')
    found: list[dict[str, Any]] = tomllib.loads(text)['item']
    return found


def test_every_item_has_a_row_with_tests_that_there_are() -> None:
    table = rows(PAGE, 'item')
    assert [(int(number), what) for number, what, _ in table] == [
        (item['number'], item['what']) for item in items()
    ]
    for item, (_, _, tests) in zip(items(), table, strict=True):
        files = re.findall(r'`([^`]+)`', tests)
        assert files
        assert {name for name in files if not name.startswith('reliability/')} == set(item['elsewhere'])
        assert [name for name in files if not (TESTS / name).is_file()] == []


def test_each_row_of_evidence_is_of_an_item_and_of_a_wire() -> None:
    numbers = {item['number'] for item in items()}
    table = rows(PAGE, 'item and fault')
    assert len(table) > 40
    for fault, *wires in table:
        assert int(fault.split(':')[0]) in numbers
        assert any(wires), fault


def test_every_fault_is_on_the_page_with_its_arguments() -> None:
    kinds = [kind for kind in vars(faults).values() if isinstance(kind, type) and is_dataclass(kind)]
    kinds = [kind for kind in kinds if kind is not Fault]
    common = {each.name for each in fields(Fault)}
    text = PAGE.read_text(encoding='utf-8')
    for kind in kinds:
        match = re.search(rf'^\| `{kind.__name__}\((.*?)\)`', text, re.MULTILINE)
        assert match, kind
        own = [each for each in fields(kind) if each.init and each.name not in common]
        if kind in {Kill, FailedCall}:
            own = [each for each in fields(kind) if each.init]
        shown = [each.name if each.default is MISSING else f'{each.name}={each.default!r}' for each in own]
        assert sorted(match[1].split(', ') if match[1] else []) == sorted(shown), kind
    for point in Point:
        assert f'`{point.name}`' in text

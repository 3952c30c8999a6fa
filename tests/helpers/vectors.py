"""The vectors of tests/data/vectors, and messages built from their JSON values."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from goalwire.cdr import layout
from goalwire.idl.model import FLOATS, FieldType, Shape

VECTORS = Path(__file__).parents[1] / 'data' / 'vectors'
WORKSPACE = Path(__file__).parents[2] / 'robot'  # has humanoid_interfaces, which the vectors include


class Case(NamedTuple):
    """One message of cdr.jsonl; `defaults` marks the first of each type."""

    type_name: str
    value: dict[str, Any]
    cdr: bytes
    defaults: bool


@cache
def cdr_cases() -> dict[str, list[Case]]:
    """Return the cases by type."""
    cases: dict[str, list[Case]] = {}
    for line in (VECTORS / 'cdr.jsonl').read_text(encoding='utf-8').splitlines():
        entry = json.loads(line)
        of_type = cases.setdefault(entry['type'], [])
        of_type.append(Case(entry['type'], entry['value'], bytes.fromhex(entry['cdr']), not of_type))
    return cases


def type_hashes() -> dict[str, str]:
    return dict(json.loads((VECTORS / 'type_hashes.json').read_text()))


def constants() -> dict[str, dict[str, Any]]:
    return dict(json.loads((VECTORS / 'constants.json').read_text()))


def descriptions() -> dict[str, list[dict[str, Any]]]:
    lines = (VECTORS / 'type_descriptions.jsonl').read_text(encoding='utf-8').splitlines()
    return {entry['type']: entry['fields'] for entry in map(json.loads, lines)}


def build(cls: type, value: dict[str, Any]) -> Any:
    """Return a message with the values of a case."""
    message = cls()
    leaves = layout.leaves(cls)
    assert [leaf.name for leaf in leaves] == list(value)
    for leaf in leaves:
        given = value[leaf.name]
        single = leaf.type.shape is Shape.SINGLE
        stored = (
            _one(leaf.type, leaf.cls, given)
            if single
            else [_one(leaf.type, leaf.cls, item) for item in given]
        )
        setattr(message, leaf.name, stored)
    return message


def _one(type_: FieldType, cls: type | None, value: Any) -> Any:
    if cls is not None:
        return build(cls, value)
    if type_.base == 'byte':
        return bytes(value)
    if type_.base in FLOATS:
        return float(value['float'] if isinstance(value, dict) else value)
    return value

"""Drafts come from browsers: what fits is shown again, and nothing else happens."""

from __future__ import annotations

import json
from typing import Any

import pytest

from goalwire.apps.console.state.draft import Draft, apply_draft, read_draft
from goalwire.apps.console.state.form_model import complete, defaults_of, form_of
from goalwire.idl.registry import register_definitions
from goalwire.observe.messages import interface_class

register_definitions(
    'console_drafts',
    {
        'msg/Hole': 'float64 depth 1.5\n',
        'msg/Everything': """
uint8 MODE_OFF=0
uint8 MODE_ON=1
uint8 mode 1
bool careful true
float64 speed
int32[3] three
console_drafts/Hole hole
console_drafts/Hole[<=2] few
console_drafts/Hole[2] pair
""",
    },
)
TYPE = 'console_drafts/msg/Everything'
GOOD: dict[str, Any] = {
    'view': 'services',
    'name': '/fill',
    'fields': {},
    'lists': {},
    'yaml': None,
    'deadline': '',
    'attempts': '',
}
WRONG: list[dict[str, Any]] = [
    {'view': 7},
    {'name': None},
    {'fields': []},
    {'fields': {'a': 1}},
    {'lists': {'a': '1'}},
    {'lists': {'a': -1}},
    {'lists': {'a': 1001}},
    {'lists': {'a': True}},
    {'yaml': 3},
    {'deadline': 3},
]


def draft(**changes: Any) -> Draft:
    """A draft as a browser keeps it."""
    found = read_draft(json.dumps(GOOD | changes))
    assert found is not None
    return found


def applied(one: Draft) -> tuple[bool, dict[str, Any], dict[str, Any]]:
    """Apply a draft to a form; return whether that has changed it, its values, and those before."""
    fields = form_of(TYPE)
    defaults = defaults_of(fields, interface_class(TYPE)())
    values = complete(fields, {}, defaults)
    return apply_draft(one, fields, values), values, complete(fields, {}, defaults)


def test_what_was_typed_is_in_the_form_again_whether_it_fits_or_not() -> None:
    texts = {'speed': 'fast', 'mode': 'OFF (0)', 'careful': 'false', 'three': '1, 2', 'hole.depth': '2'}
    has_changed, values, _ = applied(
        draft(fields=texts | {'few[1].depth': '7', 'pair[0].depth': '0.5'}, lists={'few': 2})
    )
    assert has_changed
    assert values == {
        'mode': 0, 'careful': False, 'speed': 'fast', 'three': '1, 2', 'hole': {'depth': '2'},
        'few': [{'depth': 1.5}, {'depth': '7'}], 'pair': [{'depth': '0.5'}, {'depth': 1.5}],
    }  # fmt: skip


def test_what_the_form_shows_anyway_changes_nothing() -> None:
    shown = {'speed': '0.0', 'mode': 'ON (1)', 'careful': 'true', 'three': '0, 0, 0', 'hole.depth': '1.5'}
    has_changed, values, before = applied(draft(fields=shown, lists={'few': 0, 'pair': 0}))
    assert not has_changed
    assert values == before


def test_what_the_form_has_not_is_passed_over_and_lists_stay_within_their_bounds() -> None:
    fields = {'none': '1', 'hole.none': '2', 'few[9].depth': '3', 'mode': 'SLOW (2)'}
    _, values, before = applied(draft(fields=fields, lists={'few': 1000, 'pair': 7, 'speed': 3}))
    assert len(values['few']) == 2
    assert values | {'few': []} == before


@pytest.mark.parametrize(
    'text',
    ['', 'no JSON', '[]', '{}', '[' * 10_000, 'x' * 100_001, *(json.dumps(GOOD | wrong) for wrong in WRONG)],
)
def test_a_text_that_is_no_draft_is_none(text: str) -> None:
    assert read_draft(text) is None

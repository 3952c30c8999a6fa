"""The text typed into a form and not sent yet. It comes from the browser, so each value is checked."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from goalwire.apps.console.state.form_model import FormField, choice_titles, new_item, shown_text
from goalwire.records import record

_MOST_CHARACTERS = 100_000
_MOST_ITEMS = 1000


@record
class Draft:
    """The content of one form, as the browser showed it."""

    view: str
    """The name of the view with the form."""
    name: str
    """The name of the service, action, topic or node that the form is for."""
    fields: Mapping[str, str]
    """By path: the shown text of a field."""
    lists: Mapping[str, int]
    """By path: the number of items of a list of messages."""
    yaml: str | None
    """The form as YAML; None if it was shown as fields."""
    deadline: str
    attempts: str


def read_draft(text: str) -> Draft | None:
    """Return the draft that a browser has kept; None if the text is not one."""
    if not 0 < len(text) <= _MOST_CHARACTERS:
        return None
    try:
        values = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(values, dict):
        return None
    fields, lists, yaml = values.get('fields'), values.get('lists'), values.get('yaml')
    texts = [values.get(name) for name in ('view', 'name', 'deadline', 'attempts')]
    if not (
        isinstance(fields, dict)
        and isinstance(lists, dict)
        and all(isinstance(each, str) for each in (*texts, *fields.values(), '' if yaml is None else yaml))
        and all(type(count) is int and 0 <= count <= _MOST_ITEMS for count in lists.values())
    ):
        return None
    view, name, deadline, attempts = map(str, texts)
    return Draft(view, name, fields, lists, yaml, deadline, attempts)


def apply_draft(draft: Draft, fields: tuple[FormField, ...], values: dict[str, Any], path: str = '') -> bool:
    """Put the draft's texts into the values of a form, and return True if that has changed any."""
    has_changed = False
    for field in fields:
        at = f'{path}.{field.name}' if path else field.name
        if field.kind == 'message':
            has_changed |= apply_draft(draft, field.fields, values[field.name], at)
        elif field.kind == 'messages':
            has_changed |= _apply_to_list(draft, field, values[field.name], at)
        elif at in draft.fields:
            value = _typed(field, values.get(field.name), draft.fields[at])
            has_changed |= value != values.get(field.name)
            values[field.name] = value
    return has_changed


def _apply_to_list(draft: Draft, field: FormField, items: list[Any], path: str) -> bool:
    count, before = len(items), len(items)
    if not field.exact and path in draft.lists:
        most = _MOST_ITEMS if field.capacity is None else field.capacity
        count = min(draft.lists[path], most)
    del items[count:]
    items += [new_item(field) for _ in range(count - len(items))]
    has_changed = count != before
    for number, item in enumerate(items):
        has_changed |= apply_draft(draft, field.fields, item, f'{path}[{number}]')
    return has_changed


def _typed(field: FormField, value: Any, text: str) -> Any:
    """Return the value of a field that shows this text; the present value if the text is that of it."""
    if field.kind == 'bool':
        return text == 'true'
    if field.choices:
        titles = choice_titles(field, value)
        return next((choice for choice, title in titles.items() if title == text), value)
    return value if text == shown_text(field, value) else text

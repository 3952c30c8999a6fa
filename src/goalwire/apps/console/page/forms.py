"""A form on the page, made from a form model, and its YAML text."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

from goalwire.apps.console.state.draft import Draft, apply_draft
from goalwire.apps.console.state.form_model import (
    FormField,
    check,
    choice_titles,
    complete,
    new_item,
    parse_yaml,
    shown_text,
    to_yaml,
)
from goalwire.errors import FieldValueError

_SMALL = 1 << 16
"""Integer types with this many values or fewer show their bounds below the field."""


class Form:
    """Fields to fill in. Their content is checked by `values`, not during typing."""

    def __init__(
        self, fields: tuple[FormField, ...], defaults: Mapping[str, Any], values: Mapping[str, Any]
    ) -> None:
        """`values` are the first content of the form; other fields have their defaults."""
        self._fields = fields
        self._defaults = defaults
        self._values = complete(fields, values, defaults)
        self._as_yaml = False
        self._text: ui.textarea | None = None
        with ui.column().classes('gw-form') as self._box:
            pass
        self._build()

    @property
    def is_yaml(self) -> bool:
        """Whether the form is shown as YAML."""
        return self._as_yaml

    def values(self) -> dict[str, Any]:
        """Return the form's content, checked. Raises FieldValueError."""
        if self._as_yaml and self._text is not None:
            return check(self._fields, parse_yaml(self._text.value or ''))
        return check(self._fields, self._values)

    def fill(self, values: Mapping[str, Any]) -> None:
        """Fill in other values; fields without one get their defaults."""
        self._values = complete(self._fields, values, self._defaults)
        self._build()

    def restore(self, draft: Draft) -> None:
        """Show again what was typed before the page was loaded anew, or before its connection was lost."""
        is_yaml = draft.yaml is not None
        has_changed = not is_yaml and apply_draft(draft, self._fields, self._values)
        if has_changed or is_yaml != self._as_yaml:
            self._as_yaml = is_yaml
            self._build()
        if self._text is not None:
            self._text.value = draft.yaml

    def name_draft(self, view: str, name: str) -> None:
        """Have the browser keep what is typed, for the `view` with the form of `name`."""
        self._box.props['data-draft'] = view
        self._box.props['data-name'] = name

    def toggle_yaml(self) -> None:
        """Show the form as YAML, or as a form again. Raises FieldValueError if a value does not fit."""
        self._values = complete(self._fields, self.values(), self._defaults)
        self._as_yaml = not self._as_yaml
        self._build()

    def show(self, path: str) -> None:
        """Scroll to the field of a path and focus it; for the path of a list's item, focus the list."""
        _focus(self._box, path)

    def _build(self) -> None:
        self._box.clear()
        with self._box:
            if self._as_yaml:
                self._text = (
                    ui.textarea(value=to_yaml(self._values))
                    .props(
                        'outlined dense autogrow data-yaml input-class=gw-mono aria-label="Values as YAML"'
                    )
                    .style('width: 100%')
                )
                return
            self._text = None
            if not self._fields:
                ui.label('The message has no fields.').classes('gw-dim gw-small')
            _Fields(self._fields, self._values, self._defaults, '').build()


class _Fields:
    """The fields of one message: each writes the typed text into `values`."""

    def __init__(
        self,
        fields: tuple[FormField, ...],
        values: dict[str, Any],
        defaults: Mapping[str, Any],
        path: str,
    ) -> None:
        self._fields = fields
        self._values = values
        self._defaults = defaults
        self._path = path

    def build(self) -> None:
        for field in self._fields:
            path = f'{self._path}.{field.name}' if self._path else field.name
            if field.kind == 'message':
                self._group(field, path)
            elif field.kind == 'messages':
                self._items(field, path)
            else:
                with ui.element('div').classes('gw-field'):
                    self._label(field)
                    self._input(field, path)

    def _label(self, field: FormField) -> None:
        default = shown_text(field, self._defaults.get(field.name))
        told = [field.type_text, _bounds(field) or field.hint, f'default {default}' if default else '']
        with ui.element('div').classes('gw-field-name'):
            ui.label(field.name + (f'  [{field.unit}]' if field.unit else ''))
            note = _note(field)
            with ui.label(note if len(note) < 90 else note[:88] + '…').classes('gw-field-note'):
                ui.tooltip('. '.join((', '.join(filter(None, told)), field.comment)).rstrip('. '))

    def _group(self, field: FormField, path: str) -> None:
        inner = self._values[field.name]
        with ui.element('div').classes('gw-group'):
            with ui.element('div').classes('gw-group-head'):
                _group_title(field)
            _Fields(field.fields, inner, self._defaults.get(field.name, {}), path).build()

    def _items(self, field: FormField, path: str) -> None:
        items: list[Any] = self._values[field.name]
        fresh = new_item(field)
        with ui.element('div').classes('gw-group') as box:
            pass

        def draw() -> None:
            box.clear()
            with box:
                with ui.element('div').classes('gw-group-head'):
                    _group_title(field)
                    if not field.exact:
                        _add_button(field, path, len(items), add)
                for number, item in enumerate(items):
                    with ui.element('div').classes('gw-group'):
                        with ui.element('div').classes('gw-group-head'):
                            ui.label(f'[{number}]')
                            if not field.exact:
                                _remove_button(f'{path}[{number}]', remover(number))
                        _Fields(field.fields, item, fresh, f'{path}[{number}]').build()

        def add() -> None:
            if field.capacity is None or len(items) < field.capacity:  # a double click calls `add` twice
                items.append(new_item(field))
                draw()
                _focus(box, f'{path}[{len(items) - 1}]')

        def remover(number: int) -> Callable[[], None]:
            item = items[number]

            def remove() -> None:
                items[:] = [each for each in items if each is not item]
                draw()
                _focus(box, path)

            return remove

        draw()

    def _input(self, field: FormField, path: str) -> None:
        value = self._values.get(field.name)
        mark = f'data-field="{path}"'
        name = f'{path} [{field.unit}]' if field.unit else path

        def take(event: Any) -> None:
            self._values[field.name] = event.value

        if field.kind == 'bool':
            switch = ui.switch(value=bool(value), on_change=take).props(f'dense {mark}')
            switch.style('padding-top: 6px').props['aria-label'] = name
            return
        if field.choices:
            select = ui.select(choice_titles(field, value), value=value, on_change=take).props(
                f'outlined dense {mark}'
            )
            select.style('width: 100%').props['aria-label'] = name
            return
        shown = shown_text(field, value)
        make = ui.textarea if field.kind == 'text' and '\n' in shown else ui.input
        text = make(
            value=shown,
            on_change=lambda event: self._take_text(field, event.value),
            validation=lambda typed: self._complaint(field, typed, path),
        ).props(f'outlined dense hide-bottom-space {mark}')
        text.style('width: 100%').props['aria-label'] = name
        if make is ui.textarea:
            text.props('autogrow')
        if field.kind == 'time':
            text.props('placeholder="now, or seconds since 1970"')
        elif field.kind == 'list':
            text.props(f'placeholder="none; write {_example(field)}"')
        if hint := field.hint or _bounds(field):
            text.props['hint'] = hint
        if isinstance(value, str):
            text.validate()  # The user may have typed before the field was redrawn.

    def _take_text(self, field: FormField, typed: Any) -> None:
        self._values[field.name] = typed if typed is not None else ''

    def _complaint(self, field: FormField, typed: Any, path: str) -> str | None:
        try:
            check((field,), {field.name: typed if typed is not None else ''}, path.rpartition('.')[0])
        except FieldValueError as error:
            item = error.path.removeprefix(path)
            return f'{item}: {error.problem}' if item else error.problem
        return None


def _group_title(field: FormField) -> None:
    ui.label(field.name).style('font-weight: 500')
    with ui.label(_note(field)):
        if field.comment:
            ui.tooltip(field.comment)


def _add_button(field: FormField, path: str, count: int, add: Callable[[], None]) -> None:
    full = field.capacity is not None and count >= field.capacity
    told = f'{path} is full: {field.capacity} at most' if full else f'Add one to {path}'
    with ui.element('span'):  # A disabled button gets no pointer events, so its parent shows the hint.
        button = ui.button(icon='add', on_click=add).props(f'flat dense round size=sm data-add="{path}"')
        button.props['aria-label'] = told
        button.set_enabled(not full)
        ui.tooltip(told)


def _remove_button(path: str, remove: Callable[[], None]) -> None:
    button = ui.button(icon='delete', on_click=remove).props(f'flat dense round size=sm data-remove="{path}"')
    button.props['aria-label'] = f'Remove {path}'
    button.tooltip(f'Remove {path}')


def _focus(box: ui.element, path: str) -> None:
    """Focus the field of a path: the first field of a nested message, or the list of an item."""
    box.client.run_javascript(f"""setTimeout(() => {{
      const path = {json.dumps(path)};
      const within = (one, other) => one.startsWith(other + '.') || one.startsWith(other + '[');
      const all = [...getHtmlElement({box.id}).querySelectorAll('[data-field], [data-add]')]
        .map(element => [element, element.dataset.field ?? element.dataset.add]);
      const [found] = all.find(([_, name]) => name === path) ?? all.find(([_, name]) => within(name, path))
        ?? all.findLast(([_, name]) => within(path, name)) ?? [];
      found?.focus({{ preventScroll: true }});
      found?.scrollIntoView({{ block: 'center' }}); }}, 50)""")


def _note(field: FormField) -> str:
    """Return the text below a field's name: its type, and its comment unless this is only the unit."""
    is_unit = field.comment.strip(' ()[].,') == field.unit
    return field.type_text if is_unit else f'{field.type_text} · {field.comment}'


def _bounds(field: FormField) -> str:
    """Return the bounds of the type as a text; '' if they are obvious."""
    told = []
    if field.kind == 'text' and field.capacity is not None:
        told.append(f'{field.capacity} characters at most')
    elif field.capacity is not None:
        told.append(f'{field.capacity} items' if field.exact else f'{field.capacity} items at most')
    if field.item_capacity is not None:
        told.append(f'{field.item_capacity} characters at most each')
    least, most = field.least, field.most
    if least is not None and most is not None and most - least < _SMALL and not field.choices:
        told.append(f'{least:g} to {most:g}')
    return ', '.join(told)


def _example(field: FormField) -> str:
    if field.base in {'string', 'wstring'}:
        return 'one, two'
    return 'true, false' if field.base == 'bool' else '1, 2'

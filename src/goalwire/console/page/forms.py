"""A form on the page, made from a form model, and the YAML that stands for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

from goalwire.console.form_model import FormField, check, in_one_line, parse_yaml, plain, to_yaml
from goalwire.errors import FormError


class Form:
    """Fields to fill in; `values()` gives what they hold. Raises FormError there, not while one types."""

    def __init__(self, fields: tuple[FormField, ...], values: Mapping[str, Any]) -> None:
        self._fields = fields
        self._values: dict[str, Any] = plain(values)
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
        """Return what the form holds, checked. Raises FormError."""
        if self._as_yaml and self._text is not None:
            return check(self._fields, parse_yaml(self._text.value or ''))
        return check(self._fields, self._values)

    def fill(self, values: Mapping[str, Any]) -> None:
        """Put other values in; fields that they do not name keep theirs."""
        self._values = _merged(self._values, plain(values))
        self._build()

    def toggle_yaml(self) -> None:
        """Show the form as YAML, or as a form again. Raises FormError where a value does not fit."""
        if self._as_yaml and self._text is not None:
            self._values = _merged(self._values, check(self._fields, parse_yaml(self._text.value or '')))
        else:
            self._values = _merged(self._values, check(self._fields, self._values))
        self._as_yaml = not self._as_yaml
        self._build()

    def _build(self) -> None:
        self._box.clear()
        with self._box:
            if self._as_yaml:
                self._text = (
                    ui.textarea(value=to_yaml(self._values))
                    .props('outlined dense autogrow data-yaml input-class=gw-mono')
                    .style('width: 100%')
                )
                return
            self._text = None
            if not self._fields:
                ui.label('The message has no fields.').classes('gw-dim gw-small')
            _Fields(self._fields, self._values, '').build()


class _Fields:
    """The fields of one message: each writes what is typed into `values`."""

    def __init__(self, fields: tuple[FormField, ...], values: dict[str, Any], path: str) -> None:
        self._fields = fields
        self._values = values
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
        with ui.element('div').classes('gw-field-name'):
            ui.label(field.name + (f'  [{field.unit}]' if field.unit else ''))
            note = field.comment or field.type_text
            label = ui.label(note if len(note) < 90 else note[:88] + '…').classes('gw-field-note')
            with label:
                ui.tooltip(f'{field.type_text}. {field.comment}'.strip())

    def _group(self, field: FormField, path: str) -> None:
        inner = self._values.setdefault(field.name, {})
        with ui.element('div').classes('gw-group'):
            with ui.element('div').classes('gw-group-head'):
                ui.label(field.name).style('font-weight: 500')
                ui.label(field.type_text)
            _Fields(field.fields, inner, path).build()

    def _items(self, field: FormField, path: str) -> None:
        items: list[Any] = self._values.setdefault(field.name, [])
        with ui.element('div').classes('gw-group') as box:
            pass

        def draw() -> None:
            box.clear()
            with box:
                with ui.element('div').classes('gw-group-head'):
                    ui.label(field.name).style('font-weight: 500')
                    ui.label(field.type_text)
                    if not field.exact:
                        ui.button(icon='add', on_click=add).props('flat dense round size=sm').tooltip(
                            'Add one'
                        )
                for number, item in enumerate(items):
                    with ui.element('div').classes('gw-group'):
                        with ui.element('div').classes('gw-group-head'):
                            ui.label(f'[{number}]')
                            if not field.exact:
                                ui.button(icon='delete', on_click=remover(number)).props(
                                    'flat dense round size=sm'
                                )
                        _Fields(field.fields, item, f'{path}[{number}]').build()

        def add() -> None:
            from goalwire.console.form_model import defaults_of
            from goalwire.console.types import interface

            items.append(defaults_of(field.fields, interface(field.base)()))
            draw()

        def remover(number: int) -> Callable[[], None]:
            def remove() -> None:
                del items[number]
                draw()

            return remove

        draw()

    def _input(self, field: FormField, path: str) -> None:
        value = self._values.get(field.name)
        mark = f'data-field="{path}"'

        def take(event: Any) -> None:
            self._values[field.name] = event.value

        if field.kind == 'bool':
            ui.switch(value=bool(value), on_change=take).props(f'dense {mark}').style('padding-top: 6px')
            return
        if field.choices:
            options = {choice: f'{name} ({choice})' for name, choice in field.choices}
            if value not in options:
                options = {value: f'{value}', **options}
            ui.select(options, value=value, on_change=take).props(f'outlined dense {mark}').style(
                'width: 100%'
            )
            return
        text = ui.input(
            value=_text_of(field, value),
            on_change=lambda event: self._take_text(field, event.value),
            validation=lambda typed: self._complaint(field, typed, path),
        ).props(f'outlined dense hide-bottom-space {mark}')
        text.style('width: 100%')
        if field.kind == 'time':
            text.props('placeholder="now, or seconds since 1970"')
        elif field.kind == 'list':
            text.props(
                'placeholder="1, 2, 3"'
                if field.base not in {'string', 'wstring'}
                else 'placeholder="one, two"'
            )
        if field.hint:
            text.props(f'hint="{field.hint}"')

    def _take_text(self, field: FormField, typed: Any) -> None:
        self._values[field.name] = typed if typed is not None else ''

    def _complaint(self, field: FormField, typed: Any, path: str) -> str | None:
        try:
            check((field,), {field.name: typed if typed is not None else ''}, path.rpartition('.')[0])
        except FormError as error:
            return error.problem
        return None


def _text_of(field: FormField, value: Any) -> str:
    if isinstance(value, list):
        return in_one_line(value)[1:-1]
    if isinstance(value, Mapping):
        seconds = value.get('sec', 0) + value.get('nanosec', 0) / 1e9
        return f'{seconds:g}' if field.kind == 'time' else str(value)
    return '' if value is None else str(value)


def _merged(old: Mapping[str, Any], new: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(old)
    for name, value in new.items():
        known = merged.get(name)
        merged[name] = (
            _merged(known, value) if isinstance(known, dict) and isinstance(value, Mapping) else value
        )
    return merged

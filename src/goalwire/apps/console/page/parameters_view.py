"""Parameters of all nodes, with their descriptors."""

from __future__ import annotations

from typing import Any

from nicegui import background_tasks, ui

from goalwire.apps.console.page.parts import LiveTable, head
from goalwire.apps.console.page.view import Page, View
from goalwire.apps.console.state.draft import Draft
from goalwire.apps.console.state.form_model import in_one_line
from goalwire.errors import FieldValueError, GoalwireError, RemoteError, peer_text
from goalwire.observe.parameters import (
    NodeParameters,
    RemoteParameter,
    fit_typed_value,
    nodes_with_parameters,
)
from goalwire.rules.parameters.parameter import Type, value_message
from goalwire.security.policy import Verb

_ANSWER_S = 10.0
"""How long a node may take for each answer."""


class ParametersView(View):
    """Nodes on the left, the chosen node's parameters on the right. A button beside each value sets it."""

    name = 'parameters'
    title = 'Parameters'
    icon = 'tune'
    period = 1.0

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._chosen = ''
        self._fields: dict[str, ui.switch | ui.input] = {}
        """By the parameter's name: the fields of the chosen node that the visitor may change."""

    def build(self) -> None:
        with ui.element('div').classes('gw-side gw-fill').style('grid-template-rows: minmax(0, 1fr)'):
            with ui.element('div').classes('gw-card flush'):
                head('Nodes', 'memory')
                self._table = LiveTable(
                    [{'name': 'name', 'label': 'Node', 'mono': True, 'wrap': True}],
                    empty='No node with parameters yet.',
                    on_row=self.turning_to(self._choose),
                )
            self._detail = (
                ui.element('div').classes('gw-card').style('overflow: auto').props('data-parameters')
            )
            with self._detail:
                ui.label('Choose a node to see its parameters.').classes('gw-empty')

    def refresh(self) -> None:
        own = self.node.name
        names = [
            name
            for name in nodes_with_parameters(self.node.graph.served())
            if name != own and self._may_see(name)
        ]
        self._table.put([{'key': name, 'cells': [name]} for name in names])

    def _may_see(self, name: str) -> bool:
        return self.rights.may_see('node', name) or self.rights.may(Verb.READ, name)

    async def _choose(self, name: str) -> None:
        self._chosen = name
        self._fields = {}
        self._table.choose(name)
        self._detail.clear()
        with self._detail:
            ui.spinner(size='24px')
        try:
            self.rights.check_to_read(name)
            with NodeParameters(self.node, name, _ANSWER_S) as parameters:
                found = await parameters.read()
        except GoalwireError as error:
            found, problem = [], peer_text(error, 300)
        else:
            problem = ''
        if self._chosen != name or self.page.view is not self:
            return
        self._detail.clear()
        with self._detail:
            with ui.element('div').classes('gw-head'):
                ui.label(name).classes('gw-title gw-mono')
                ui.label(f'{len(found)} parameters').classes('gw-chip')
                ui.element('div').classes('gw-spread')
                ui.button('Read again', icon='refresh', on_click=lambda: self._choose(name)).props(
                    'flat dense no-caps'
                )
            if problem:
                ui.label(problem).classes('gw-problem')
            with ui.element('div') as rows:
                rows.props['data-draft'], rows.props['data-name'] = self.name, name
                for parameter in found:
                    self._row(name, parameter)

    def resume(self, draft: Draft) -> bool:
        if draft.name == self._chosen:
            self._restore(draft)
        elif draft.name in nodes_with_parameters(self.node.graph.served()):
            background_tasks.create(self._resume(draft))
        else:
            return False
        return True

    async def _resume(self, draft: Draft) -> None:
        await self._choose(draft.name)
        if self._chosen == draft.name:
            self._restore(draft)

    def _restore(self, draft: Draft) -> None:
        for name, text in draft.fields.items():
            field = self._fields.get(name)
            if field is not None:
                field.value = text == 'true' if isinstance(field, ui.switch) else text

    def _row(self, node: str, parameter: RemoteParameter) -> None:
        with ui.element('div').classes('gw-field'):
            with ui.element('div').classes('gw-field-name'):
                ui.label(parameter.name).classes('gw-mono')
                for note in (_bounds(parameter), parameter.description, parameter.constraints):
                    if note:
                        ui.label(note).classes('gw-field-note')
            with ui.element('div').classes('gw-actions').style('flex-wrap: nowrap'):
                self._editor(node, parameter)

    def _editor(self, node: str, parameter: RemoteParameter) -> None:
        reason = self.rights.why_not(Verb.SET, node)
        locked = parameter.read_only or parameter.number == 0 or bool(reason)
        field: ui.switch | ui.input
        if parameter.number == 1:
            field = ui.switch(value=bool(parameter.value)).props('dense')
        else:
            field = ui.input(value=_text(parameter)).props('outlined dense').style('flex: 1')
        field.props['data-parameter'] = parameter.name
        field.props['data-was'] = str(field.value).lower() if parameter.number == 1 else field.value
        if locked:
            field.disable()
            kind = ui.label('read-only' if parameter.read_only else parameter.kind).classes('gw-chip')
            if reason:
                kind.tooltip(reason)
                kind.props['data-why'] = reason
            return
        self._fields[parameter.name] = field
        ui.label(parameter.kind).classes('gw-chip')

        async def put() -> None:
            await self._set(node, parameter, field.value)

        button = ui.button('Set', on_click=put).props('flat dense no-caps color=primary')
        button.props['data-set'] = parameter.name

    async def _set(self, node: str, parameter: RemoteParameter, typed: Any) -> None:
        try:
            value = fit_typed_value(parameter, typed)
        except FieldValueError as error:
            self.page.tell(' '.join(str(error).split()), 'warning')
            return
        text = f'ros2 param set {node} {parameter.name} {_in_one_line(value)}'
        if not await self.page.confirm('parameters', node, 'Set this parameter?', text, 'Set'):
            return

        if await self.page.attempt(self._put(node, parameter, value)):
            self.page.tell(f'{parameter.name} is set')
            await self._choose(node)

    async def _put(self, node: str, parameter: RemoteParameter, value: Any) -> bool:
        """Set a parameter; raises NotAllowedError, and RemoteError if the node says no."""
        self.rights.check(Verb.SET, node, f'{parameter.name}: {_in_one_line(value)}')
        message = value_message(Type(parameter.number), value)
        with NodeParameters(self.node, node, _ANSWER_S) as parameters:
            [(_, result)] = await parameters.set([(parameter.name, message)])
        if not result.successful:
            raise RemoteError(result.reason or 'the node refused the value')
        return True


def _bounds(parameter: RemoteParameter) -> str:
    if parameter.least is None or parameter.most is None:
        return ''
    step = f', in steps of {parameter.step:g}' if parameter.step else ''
    return f'{parameter.least:g} to {parameter.most:g}{step}'


def _text(parameter: RemoteParameter) -> str:
    return (
        parameter.value
        if isinstance(parameter.value, str)
        else ''
        if parameter.value is None
        else in_one_line(parameter.value)
    )


def _in_one_line(value: Any) -> str:
    """Return a value as `ros2 param set` accepts it, bytes as numbers."""
    is_bytes = isinstance(value, list) and value and isinstance(value[0], bytes)
    return in_one_line([item[0] for item in value] if is_bytes else value)

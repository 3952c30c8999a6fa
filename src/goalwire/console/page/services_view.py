"""Services: forms made from their definitions, responses, and how long calls take."""

from __future__ import annotations

from time import localtime, strftime
from typing import Any

from nicegui import ui

from goalwire.console.form_model import to_yaml
from goalwire.console.page.forms import Form
from goalwire.console.page.graph_view import PARAMETER_SERVICES
from goalwire.console.page.parts import LiveTable, ValueTree, copy_buttons, head
from goalwire.console.page.view import View, duration
from goalwire.console.sending import Sent, Target
from goalwire.console.snippets import Sending, as_command, as_python
from goalwire.errors import FormError, GoalwireError, peer_text

_TIMEOUT_S = 5.0


class ServicesView(View):
    """A list of services on the left, form, response and latencies of the chosen one on the right."""

    name = 'services'
    title = 'Services'
    icon = 'settings_remote'
    period = 1.0

    def build(self) -> None:
        self._filter = ''
        self._all = False
        self._target: Target | None = None
        self._form: Form | None = None
        with ui.element('div').classes('gw-side gw-fill').style('grid-template-rows: minmax(0, 1fr)'):
            with ui.element('div').classes('gw-card flush'):
                with ui.element('div').classes('gw-head'):
                    head('Services', 'settings_remote')
                    ui.element('div').classes('gw-spread')
                    ui.switch('Parameters', on_change=self._set_all).props('dense size=sm').classes(
                        'gw-small'
                    )
                with ui.element('div').style('padding: 0 16px'):
                    ui.input(placeholder='Filter', on_change=self._set_filter).props(
                        'outlined dense clearable data-filter'
                    )
                self._table = LiveTable(
                    [{'name': 'name', 'label': 'Name', 'mono': True}, {'name': 'type', 'label': 'Type'}],
                    empty='No services yet.',
                    on_row=self._choose,
                )
            self._detail = ui.element('div').classes('gw-stack').style('overflow: auto')
            with self._detail, ui.element('div').classes('gw-card'):
                ui.label('Choose a service to call it.').classes('gw-empty')

    def _set_filter(self, event: Any) -> None:
        self._filter = (event.value or '').lower()
        self.page.refresh_soon()

    def _set_all(self, event: Any) -> None:
        self._all = bool(event.value)
        self.page.refresh_soon()

    def refresh(self) -> None:
        rows = []
        for name, types in self.node.graph.services():
            if '/_action/' in name or self._filter not in f'{name} {types[0]}'.lower():
                continue
            if not self._all and name.endswith(PARAMETER_SERVICES):
                continue
            short = types[0].replace('/srv/', '/')
            tone = {'tone': 'bad'} if len(types) > 1 else {}
            rows.append({'key': name, 'cells': [name, {'text': short, 'title': ', '.join(types)}], **tone})
        self._table.put(rows)

    # -- one service -----------------------------------------------------------------------------------------

    def _choose(self, name: str) -> None:
        types = dict(self.node.graph.services()).get(name)
        if not types:
            return
        self._table.choose(name)
        self._detail.clear()
        try:
            self._target = target = self.session.sender.target('service', name, types[0])
        except GoalwireError as error:
            with self._detail:
                ui.label(peer_text(error, 400)).classes('gw-problem')
            return
        with self._detail:
            with ui.element('div').classes('gw-card'):
                with ui.element('div').classes('gw-head'):
                    ui.label(name).classes('gw-title gw-mono')
                    ui.label(target.type_name).classes('gw-chip')
                self._form = Form(target.fields, target.defaults)
                self._buttons(target)
            self._answer_card = ui.element('div').classes('gw-card').props('data-answer')
            with ui.element('div').classes('gw-two'):
                with ui.element('div').classes('gw-card'):
                    self._latency_head = ui.element('div').classes('gw-head')
                    self._chart = ui.echart(_bars([], [], dark=self.page.is_dark)).style(
                        'height: 170px; width: 100%'
                    )
                with ui.element('div').classes('gw-card flush'):
                    with ui.element('div').classes('gw-head'):
                        head('History', 'history')
                    self._history = LiveTable(
                        [
                            {'name': 'at', 'label': 'At', 'width': '84px'},
                            {'name': 'took', 'label': 'Took', 'align': 'right', 'width': '84px'},
                            {'name': 'what', 'label': 'Request', 'mono': True},
                        ],
                        empty='Calls from here are kept while the console runs.',
                        on_row=self._use_again,
                    )
        history = self.session.sender.history.get(('service', name))
        self._show(history[-1] if history else None)

    def _buttons(self, target: Target) -> None:
        with ui.element('div').classes('gw-actions'):
            call = ui.button('Call', icon='send', on_click=self._call).props(
                'unelevated dense no-caps color=primary data-call padding="4px 14px"'
            )
            if not self.settings.may_send(target.name):
                call.disable()
                call.tooltip('This console may not send to it')
            self._timeout = (
                ui.number('Deadline [s]', value=_TIMEOUT_S, min=0.1, step=1)
                .props('outlined dense data-deadline')
                .style('width: 112px')
            )
            self._attempts = (
                ui.number('Attempts', value=1, min=1, max=10, step=1, precision=0)
                .props('outlined dense data-attempts')
                .style('width: 92px')
            )
            self._attempts.tooltip(
                'More than one: the request may be handled twice, so the service must be idempotent'
            )
            ui.button('YAML', icon='data_object', on_click=self._toggle_yaml).props(
                'flat dense no-caps data-toggle-yaml'
            )
            ui.element('div').classes('gw-spread')
            copy_buttons(lambda: self._copied(as_python), lambda: self._copied(as_command))

    def _toggle_yaml(self) -> None:
        if self._form is not None:
            try:
                self._form.toggle_yaml()
            except FormError as error:
                self.page.tell(str(error), 'warning')

    def _sending(self) -> Sending | None:
        if self._form is None or self._target is None:
            return None
        try:
            return self._target.sending(self._form.values(), float(self._timeout.value or _TIMEOUT_S))
        except FormError as error:
            self.page.tell(str(error), 'warning')
            return None

    def _copied(self, write: Any) -> str | None:
        sending = self._sending()
        return None if sending is None else str(write(sending))

    async def _call(self) -> None:
        sending, target = self._sending(), self._target
        if sending is None or target is None:
            return
        if not await self.page.confirm(
            'service', target.name, 'Call this service?', as_command(sending), 'Call'
        ):
            return
        attempts = int(self._attempts.value or 1)
        sent = await self.page.attempt(self.session.sender.call(target, sending, attempts))
        if sent is not None and self._target is target:
            self._show(sent)

    def _use_again(self, key: str) -> None:
        if self._target is None or self._form is None:
            return
        for sent in self.session.sender.history.get(('service', self._target.name), ()):
            if f'{sent.at}' == key:
                self._form.fill(sent.sending.values)
                self._show(sent)

    def _show(self, sent: Sent | None) -> None:
        assert self._target is not None
        self._answer_card.clear()
        self._answer_card.set_visibility(sent is not None)
        if sent is not None:
            with self._answer_card:
                with ui.element('div').classes('gw-head'):
                    head('Response', 'subdirectory_arrow_right')
                    ui.label(duration(sent.seconds)).classes('gw-chip')
                    success = (sent.answer or {}).get('success')
                    if isinstance(success, bool):
                        ui.label('success' if success else 'no success').classes(
                            f'gw-chip {"good" if success else "bad"}'
                        )
                if sent.problem:
                    ui.label(sent.problem).classes('gw-problem').props('data-problem')
                else:
                    ValueTree(empty='').put(dict(sent.answer or {}))
        self._put_history()
        self._put_latencies()

    def _put_history(self) -> None:
        assert self._target is not None
        rows = [
            {
                'key': f'{sent.at}',
                'cells': [
                    strftime('%H:%M:%S', localtime(sent.at)),
                    duration(sent.seconds),
                    sent.problem or (to_yaml(sent.sending.values).strip() if sent.sending.values else '{}'),
                ],
                **({'tone': 'bad'} if sent.problem else {}),
            }
            for sent in reversed(self.session.sender.history.get(('service', self._target.name), ()))
        ]
        self._history.put(rows)

    def _put_latencies(self) -> None:
        assert self._target is not None
        latencies = self.session.sender.latencies.get(self._target.name)
        self._latency_head.clear()
        with self._latency_head:
            head('Latency', 'timer')
            ui.element('div').classes('gw-spread')
            if latencies is not None:
                for share in (0.5, 0.95, 0.99):
                    ui.label(f'p{share * 100:.0f} {duration(latencies.percentile(share))}').classes(
                        'gw-chip info'
                    )
        edges, counts = latencies.histogram() if latencies is not None else ([], [])
        self._chart.options.clear()
        self._chart.options.update(_bars(edges, counts, dark=self.page.is_dark))
        self._chart.update()


def _bars(edges: list[float], counts: list[int], *, dark: bool) -> dict[str, Any]:
    dim, line = ('#93a1b8', '#243146') if dark else ('#64748b', '#e2e8f0')
    return {
        'animation': False,
        'grid': {'left': 8, 'right': 8, 'top': 10, 'bottom': 4, 'containLabel': True},
        'tooltip': {'renderMode': 'richText'},
        'xAxis': {
            'type': 'category',
            'data': [duration(edge) for edge in edges[:-1]],
            'axisLabel': {'color': dim, 'fontSize': 10},
            'axisLine': {'lineStyle': {'color': line}},
        },
        'yAxis': {
            'type': 'value',
            'minInterval': 1,
            'axisLabel': {'color': dim, 'fontSize': 10},
            'splitLine': {'lineStyle': {'color': line}},
        },
        'series': [
            {
                'type': 'bar',
                'data': counts,
                'color': '#6366f1',
                'barCategoryGap': '12%',
                'itemStyle': {'borderRadius': [3, 3, 0, 0]},
            }
        ],
    }

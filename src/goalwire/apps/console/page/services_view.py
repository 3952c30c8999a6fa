"""Services: forms made from their definitions, responses, and how long calls take."""

from __future__ import annotations

from typing import Any

from nicegui import ui

import goalwire
from goalwire.aio.graph import EndpointKind
from goalwire.apps.console.page.charts import histogram_options, rest_while_still
from goalwire.apps.console.page.parts import LiveTable, ValueTree, head
from goalwire.apps.console.page.send_form import SendForm
from goalwire.apps.console.page.view import Page, View, duration
from goalwire.apps.console.state.draft import Draft
from goalwire.apps.console.state.form_model import in_one_line
from goalwire.apps.console.state.sending import Sent
from goalwire.apps.console.state.topics import Reading
from goalwire.errors import GoalwireError, peer_text
from goalwire.observe.clock import time_of_day
from goalwire.observe.messages import as_data
from goalwire.observe.parameters import STANDARD_SERVICES
from goalwire.observe.service_calls import POSTFIX, SeenCall, ServiceCalls
from goalwire.security.policy import Verb

_CALLS_SHOWN = 100
_TIMEOUT_S = 10.0


class ServicesView(View):
    """A list of services on the left; on the right the form, the response and the latencies of the chosen
    one.
    """

    name = 'services'
    title = 'Services'
    icon = 'settings_remote'
    period = 1.0

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._filter = ''
        self._all = False
        self._form: SendForm | None = None
        self._events = ServiceCalls()
        self._event_reading: Reading | None = None
        self._events_shown = -1

    def build(self) -> None:
        with ui.element('div').classes('gw-side gw-fill').style('grid-template-rows: minmax(0, 1fr)'):
            with ui.element('div').classes('gw-card flush'):
                with head('Services', 'settings_remote'):
                    ui.element('div').classes('gw-spread')
                    ui.switch('Parameters', on_change=self._set_all).props('dense size=sm').classes(
                        'gw-small'
                    )
                with ui.element('div').style('padding: 0 16px'):
                    ui.input(placeholder='Filter', on_change=self._set_filter).props(
                        'outlined dense clearable data-filter'
                    )
                self._table = LiveTable(
                    [
                        {'name': 'name', 'label': 'Name', 'mono': True, 'wrap': True},
                        {'name': 'type', 'label': 'Type', 'wrap': True},
                    ],
                    empty='No services yet.',
                    on_row=self.turning_to(self._choose),
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
        own = self.node.name
        called = {
            end.name
            for end in self.node.graph.endpoints()
            if end.kind is EndpointKind.CLIENT and end.node.qualified != own
        }
        for name, types in self.node.graph.services():
            if '/_action/' in name or self._filter not in f'{name} {types[0]}'.lower():
                continue
            if not self._all and name.endswith(STANDARD_SERVICES):
                continue
            if not self.rights.may_see('service', name):
                continue
            is_served = bool(self.node.graph.servers(name))
            if not is_served and name not in called:
                continue  # its only client is this console
            short = types[0].replace('/srv/', '/')
            tone = {'tone': 'bad'} if len(types) > 1 else {} if is_served else {'tone': 'dim'}
            text = short if is_served else f'{short}, without a server'
            rows.append({'key': name, 'cells': [name, {'text': text, 'title': ', '.join(types)}], **tone})
        self._table.put(rows)
        self._refresh_events()

    # -- one service -----------------------------------------------------------------------------------------

    def _choose(self, name: str) -> None:
        types = dict(self.node.graph.services()).get(name)
        if not types:
            return
        self._table.choose(name)
        self._forget_events()
        self._form = None
        self._detail.clear()
        try:
            target = self.session.sender.target('service', name, types[0])
        except GoalwireError as error:
            with self._detail:
                ui.label(peer_text(error, 400)).classes('gw-problem')
            return
        with self._detail:
            with ui.element('div').classes('gw-card'):
                with ui.element('div').classes('gw-head'):
                    ui.label(name).classes('gw-title gw-mono')
                    ui.label(target.type_name).classes('gw-chip')
                self._form = SendForm(self.page, target)
                self._form.keep_draft(self.name)
                self._buttons(self._form)
            self._answer_card = ui.element('div').classes('gw-card').props('data-answer')
            with ui.element('div').classes('gw-two'):
                with ui.element('div').classes('gw-card'):
                    self._latency_head = ui.element('div')
                    self._chart = ui.echart(histogram_options([], dark=self.page.is_dark)).style(
                        'height: 170px; width: 100%'
                    )
                    rest_while_still(self._chart)
                with ui.element('div').classes('gw-card flush'):
                    head('History', 'history')
                    self._form.history(self._show)
            self._build_events()
        self._show(self._form.sent[-1] if self._form.sent else None)
        self._refresh_events()

    def resume(self, draft: Draft) -> bool:
        if self._form is None or self._form.target.name != draft.name:
            if draft.name not in dict(self.node.graph.services()):
                return False
            self._choose(draft.name)
        if self._form is not None:
            self._form.restore(draft)
        return True

    def _build_events(self) -> None:
        with ui.element('div').classes('gw-card flush').props('data-events') as self._event_card:
            with head('Calls of everybody', 'sensors'):
                ui.label('from service introspection').classes('gw-dim gw-small')
            self._event_table = LiveTable(
                [
                    {'name': 'at', 'label': 'At', 'width': '84px'},
                    {'name': 'client', 'label': 'Client', 'mono': True, 'width': '108px'},
                    {'name': 'request', 'label': 'Request', 'mono': True},
                    {'name': 'response', 'label': 'Response', 'mono': True},
                    {'name': 'served', 'label': 'Served in', 'align': 'right', 'width': '84px'},
                    {'name': 'took', 'label': 'Took', 'align': 'right', 'width': '84px'},
                ],
                empty='Nobody has called it since you chose it.',
            )

    def _buttons(self, form: SendForm) -> None:
        with ui.element('div').classes('gw-actions gw-send'):
            form.send_button('Call', 'data-call', self._call)
            form.deadline_field(_TIMEOUT_S)
            form.attempts_field()
            form.yaml_button()
            ui.element('div').classes('gw-spread')
            form.copy_buttons()

    async def _call(self) -> None:
        form = self._form
        sending = None if form is None else await form.confirm('Call this service?', 'Call')
        if form is None or sending is None:
            return
        sent = await self.page.attempt(self.session.sender.call(form.target, sending, self.rights))
        if sent is not None and self._form is form:
            self._show(sent)

    # -- introspection ---------------------------------------------------------------------------------------

    def _refresh_events(self) -> None:
        if self._form is None:
            return
        target = self._form.target
        topic = target.name + POSTFIX
        there = bool(self.node.graph.publishers(topic)) and self.rights.may(Verb.SUBSCRIBE, topic)
        if there and self._event_reading is None:
            qos = goalwire.QoS(depth=1000)
            self._event_reading = self.session.topics.read(
                topic, f'{target.type_name}_Event', self._events.take, qos
            )
        self._event_card.set_visibility(there or self._events.version > 0)
        if self._events.version != self._events_shown:
            self._events_shown = self._events.version
            self._event_table.put([_event_row(call) for call in self._events.latest(_CALLS_SHOWN)])

    def _forget_events(self) -> None:
        if self._event_reading is not None:
            self._event_reading.close()
        self._event_reading, self._events, self._events_shown = None, ServiceCalls(), -1

    def close(self) -> None:
        self._forget_events()

    # -- calls from this console -----------------------------------------------------------------------------

    def _show(self, sent: Sent | None) -> None:
        assert self._form is not None
        self._answer_card.clear()
        self._answer_card.set_visibility(sent is not None)
        if sent is not None:
            with self._answer_card:
                with head('Response', 'subdirectory_arrow_right'):
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
        self._form.put_history()
        self._put_latencies()

    def _put_latencies(self) -> None:
        assert self._form is not None
        latencies = self.session.sender.latencies.get(self._form.target.name)
        self._latency_head.clear()
        with self._latency_head, head('Latency', 'timer'):
            ui.element('div').classes('gw-spread')
            if latencies is not None:
                for share in (0.5, 0.95, 0.99):
                    ui.label(f'p{share * 100:.0f} {duration(latencies.percentile(share))}').classes(
                        'gw-chip info'
                    )
        bins = latencies.histogram() if latencies is not None else []
        self._chart.options.clear()
        self._chart.options.update(histogram_options(bins, dark=self.page.is_dark))
        self._chart.update()


def _event_row(call: SeenCall) -> dict[str, Any]:
    answer = in_one_line(as_data(call.response)) if call.response is not None else call.state
    cells = [
        time_of_day(call.seen_at),
        {'text': f'…{call.client[-8:]} {call.number}', 'title': call.client},
        '' if call.request is None else in_one_line(as_data(call.request)),
        {'text': answer, 'title': call.state},
        '' if call.served_in is None else duration(call.served_in),
        '' if call.took is None else duration(call.took),
    ]
    return {'key': f'{call.client} {call.number}', 'cells': cells}

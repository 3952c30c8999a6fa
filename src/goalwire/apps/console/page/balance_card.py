"""The card of a robot that can fall: how it stands, a button that puts it up, and pushes in simulation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import ui

from goalwire.apps.console.page.parts import head
from goalwire.apps.console.state.balance import PUSH_S, Balance, Service, push_values
from goalwire.errors import peer_text

if TYPE_CHECKING:
    from goalwire.apps.console.page.view import Page
    from goalwire.apps.console.state.robot_watch import RobotWatch

_USUAL_N = 60.0
_MOST_N = 2000.0
_ANSWER_S = 10.0
_WAYS = (
    ('ahead', 0.0, 'arrow_upward'),
    ('left', 90.0, 'arrow_back'),
    ('right', -90.0, 'arrow_forward'),
    ('back', 180.0, 'arrow_downward'),
)


class BalanceCard:
    """Shown for a robot with the topic `fallen`. Each push, and getting up, asks first."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._session = page.session
        self._balance = Balance(page.session.node, page.session.topics)
        self._watch: RobotWatch | None = None
        with ui.element('div').classes('gw-card').props('data-balance') as self._card:
            with head('Balance', 'accessibility_new'):
                ui.element('div').classes('gw-spread')
                self._state = ui.label('').classes('gw-chip').props('data-balance-state')
            self._get_up = ui.button('Get up', icon='upload', on_click=self._put_up)
            self._get_up.props('unelevated dense no-caps color=primary data-get-up padding="4px 14px"')
            with ui.element('div').classes('gw-actions') as self._pushes:
                self._newtons = ui.number('Push, N', value=_USUAL_N, min=1.0, max=_MOST_N, step=10.0)
                self._newtons.props('outlined dense').style('width: 110px')
                for way, degrees, icon in _WAYS:
                    button = ui.button(
                        icon=icon, on_click=lambda way=way, degrees=degrees: self._push(way, degrees)
                    )
                    button.props(f'flat dense round data-push={way} aria-label="Push it {way}"')
                    button.tooltip(f'Push it {way}, for {PUSH_S} s')
        self._card.set_visibility(False)

    def look(self, robot: str) -> None:
        """Find the topic and the services of a robot in the graph."""
        self._balance.look(robot)
        self._card.set_visibility(self._balance.is_told or bool(self._balance.problem))
        self._pushes.set_visibility(self._may_call(self._balance.push))

    def refresh(self, watch: RobotWatch) -> None:
        """Show whether the robot is on its feet or has fallen."""
        self._watch = watch
        fallen = self._balance.has_fallen
        self._state.set_text(
            self._balance.problem or {None: 'not known', True: 'fallen', False: 'on its feet'}[fallen]
        )
        tone = {None: 'warn', True: 'bad', False: 'good'}[fallen]
        self._state.classes(add=tone, remove=' '.join({'warn', 'bad', 'good'} - {tone}))
        self._get_up.set_visibility(bool(fallen) and self._may_call(self._balance.get_up))

    def _may_call(self, service: Service | None) -> bool:
        return service is not None and not self._page.rights.why_not_send('service', service.name)

    async def _put_up(self) -> None:
        await self._call(self._balance.get_up, {}, 'Put the robot back on its feet?', '', 'Get up')

    async def _push(self, way: str, degrees: float) -> None:
        watch, newtons = self._watch, self._newtons.value
        if watch is None or watch.model is None or newtons is None:
            return
        root = f'{watch.prefix}{watch.model.kinematics.root}'
        if root not in watch.frames:
            self._page.tell('Where the robot faces is not known: its pose has not come', 'warning')
            return
        values = push_values(float(newtons), degrees, watch.frames[root][1])
        text = f'{newtons:g} N for {PUSH_S} s, {way}'
        await self._call(self._balance.push, values, 'Push the robot? It may fall.', text, 'Push')

    async def _call(
        self, service: Service | None, values: dict[str, Any], title: str, text: str, button: str
    ) -> None:
        if service is None or not await self._page.confirm('service', service.name, title, text, button):
            return
        await self._page.attempt(self._send(service, values))

    async def _send(self, service: Service, values: dict[str, Any]) -> None:
        sender = self._session.sender
        target = sender.target('service', service.name, service.type_name)
        sent = await sender.call(target, target.sending(values, timeout=_ANSWER_S), self._page.rights)
        answer = sent.answer or {}
        is_done = bool(answer.get('success', False))
        self._page.tell(
            sent.problem or peer_text(answer.get('message', ''), 300), 'positive' if is_done else 'negative'
        )

    def close(self) -> None:
        """End the subscription."""
        self._balance.close()

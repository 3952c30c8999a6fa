"""The card that drives a robot by hand. Nothing is sent until the visitor has switched it on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import ui
from nicegui.element import Element

from goalwire.apps.console.page.parts import head
from goalwire.apps.console.state.listened import listened_topics
from goalwire.apps.console.state.teleop import TWIST, TWIST_STAMPED, Teleop, twist_values
from goalwire.errors import GoalwireError, peer_text

if TYPE_CHECKING:
    import goalwire
    from goalwire.apps.console.page.view import Page
    from goalwire.apps.console.state.sending import Target

_SPEED, _TURN = 0.3, 0.6
_MOST_SPEED, _MOST_TURN = 2.0, 3.0


class TeleopPad(Element, component='teleop_pad.js'):
    """A pad that is held to drive."""


class TeleopCard:
    """Shown for a robot that listens to velocities. The robot moves while the pad is held."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._teleop = Teleop(self._send, lambda reason: page.tell(reason, 'warning'))
        self._topics: dict[str, str] = {}
        self._target: Target | None = None
        self._publisher: goalwire.Publisher[Any] | None = None
        with ui.element('div').classes('gw-card').props('data-teleop') as self._card:
            with head('Drive by hand', 'gamepad'):
                ui.element('div').classes('gw-spread')
                self._switch = ui.switch(on_change=self._turn).props('dense size=sm data-teleop-on')
                self._switch.props['aria-label'] = 'Drive by hand'
            self._topic = ui.select({}, label='Velocities go to', on_change=self._turn_off)
            self._topic.props('outlined dense options-dense data-teleop-topic').style('width: 100%')
            with ui.element('div').classes('gw-drive') as self._drive:
                pad = TeleopPad().props('data-teleop-pad')
                pad.on('hold', self._on_hold)
                pad.on('release', self._teleop.release)
                with ui.element('div').classes('gw-stack').style('gap: 8px'):
                    self._speed = _number('Ahead at most, m/s', _SPEED, _MOST_SPEED)
                    self._turning = _number('Turns at most, rad/s', _TURN, _MOST_TURN)
            self._drive.set_visibility(False)
        self._card.set_visibility(False)

    def look(self, robot: str) -> None:
        """Find the topics by which this robot, and no other one, is driven."""
        rights, session = self._page.rights, self._page.session
        found = listened_topics(session.node, {TWIST, TWIST_STAMPED})
        topics = {
            name: type_name
            for name, type_name in sorted(found.items(), key=lambda each: (len(each[0]), each[0]))
            if session.may_move(name, robot) and not rights.why_not_send('topic', name)
        }
        if topics != self._topics:
            self._topics = topics
            kept = self._topic.value if self._topic.value in topics else next(iter(topics), None)
            self._topic.set_options({name: name for name in topics}, value=kept)
        if self._target is not None and self._topics.get(self._target.name) != self._target.type_name:
            self._turn_off()
        self._card.set_visibility(bool(topics))

    async def _turn(self, event: Any) -> None:
        if not event.value:
            self._turn_off()
            return
        name = str(self._topic.value or '')
        if self._target is None and name in self._topics:
            text = 'The robot moves while you hold the pad, and stops when you let it go.'
            if await self._page.confirm('teleop', name, 'Drive by hand?', text, 'Drive', may_trust=False):
                self._take(name)
        self._show()

    def _take(self, name: str) -> None:
        rights, sender = self._page.rights, self._page.session.sender
        try:
            target = sender.target('topic', name, self._topics.get(name, TWIST))
            rights.check_to_send('topic', name, 'by hand')
            self._publisher = sender.publisher(target, rights)
        except GoalwireError as error:
            self._page.tell(peer_text(error, 400), 'negative')
            return
        self._target = target

    def _turn_off(self) -> None:
        self._teleop.release()
        self._target = self._publisher = None
        self._show()

    def _show(self) -> None:
        is_on = self._target is not None
        self._switch.set_value(is_on)
        self._drive.set_visibility(is_on)

    def _on_hold(self, event: Any) -> None:
        if self._target is None:
            return
        said = event.args
        self._teleop.hold(*(float(said[name]) for name in ('press', 'at', 'ahead', 'left')))

    def _send(self, ahead: float, left: float) -> None:
        target, publisher = self._target, self._publisher
        if target is None or publisher is None:
            return
        ahead *= min(float(self._speed.value or 0.0), _MOST_SPEED)
        left *= min(float(self._turning.value or 0.0), _MOST_TURN)
        try:
            sending = target.sending(twist_values(target.type_name, ahead, left))
            publisher.publish(target.message(sending, self._page.session.node.clock.now().to_msg()))
        except GoalwireError as error:
            self._page.tell(peer_text(error, 400), 'negative')

    def close(self) -> None:
        """Stop the robot if it is being driven."""
        self._teleop.release()


def _number(label: str, value: float, most: float) -> ui.number:
    number = ui.number(label, value=value, min=0.0, max=most, step=0.05)
    number.props('outlined dense')
    return number

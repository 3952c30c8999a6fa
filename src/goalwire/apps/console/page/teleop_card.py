"""The card that drives a robot by hand. Nothing is sent until the visitor has switched it on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import ui
from nicegui.element import Element

from goalwire.apps.console.page.parts import head
from goalwire.apps.console.state.listened import listened_topics
from goalwire.apps.console.state.teleop import TWIST, TWIST_STAMPED, Teleop, twist_values, within
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
        self._teleop = Teleop(self._send, self._on_lost)
        self._topics: dict[str, str] = {}
        self._target: Target | None = None
        self._publisher: goalwire.Publisher[Any] | None = None
        self._driven: tuple[Target, goalwire.Publisher[Any]] | None = None
        """The topic that the last press drives, and its publisher: the repeats of its stop need them."""
        with ui.element('div').classes('gw-card').props('data-teleop') as self._card:
            with head('Drive by hand', 'gamepad'):
                ui.element('div').classes('gw-spread')
                self._switch = ui.switch(on_change=self._turn).props('dense size=sm data-teleop-on')
                self._switch.props['aria-label'] = 'Drive by hand'
            self._topic = ui.select({}, label='Velocities go to', on_change=self._turn_off)
            self._topic.props('outlined dense options-dense data-teleop-topic').style('width: 100%')
            with ui.element('div').classes('gw-drive') as self._drive:
                self._pad = TeleopPad().props('data-teleop-pad')
                self._pad.on('hold', self._on_hold)
                self._pad.on('release', self._on_release)
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
        """Prepare to drive by a topic, if it is still the chosen one: the question may have taken long."""
        page, sender = self._page, self._page.session.sender
        if page.closed or name != self._topic.value or name not in self._topics:
            return
        try:
            target = sender.target('topic', name, self._topics[name])
            self._publisher = sender.publisher(target, page.rights)
        except GoalwireError as error:
            page.tell(peer_text(error, 400), 'negative')
            return
        self._target = target

    def _turn_off(self) -> None:
        self._let_go()
        self._target = self._publisher = None
        self._show()

    def _show(self) -> None:
        is_on = self._target is not None
        self._switch.set_value(is_on)
        self._drive.set_visibility(is_on)

    # -- the hand on the pad ---------------------------------------------------------------------------------

    def _on_hold(self, event: Any) -> None:
        target, publisher = self._target, self._publisher
        if target is None or publisher is None:
            return
        press, at, ahead, left = (float(event.args[name]) for name in ('press', 'at', 'ahead', 'left'))
        if self._why_not(target.name):
            self._turn_off()
            return
        if self._teleop.is_new(press):
            if not self._page.session.teleops.take(target.name, self._teleop):
                self._page.tell('Somebody else drives it by hand', 'warning')
                self._turn_off()
                return
            self._page.rights.check_to_send('topic', target.name, 'by hand')
            self._driven = target, publisher
        self._teleop.hold(press, at, ahead, left)
        self._pad.run_method('heard', at)

    def _why_not(self, topic: str) -> str:
        """Return why the visitor may not drive, or not any more; '' if it may."""
        page = self._page
        if page.closed or not page.session.may_move(topic, page.robot):
            return 'it moves another robot'
        return page.rights.problem() or page.rights.why_not_send('topic', topic)

    def _on_release(self, event: Any) -> None:
        if self._teleop.drives and event.args == 'deaf':
            self._page.tell('The console answers late: the robot was stopped.', 'warning')
        self._let_go()

    def _on_lost(self, reason: str) -> None:
        self._page.session.teleops.give_back(self._teleop)
        self._page.tell(reason, 'warning')

    def _let_go(self) -> None:
        self._teleop.release()
        self._page.session.teleops.give_back(self._teleop)

    def _send(self, ahead: float, left: float) -> None:
        if self._driven is None:
            return
        target, publisher = self._driven
        ahead *= within(self._speed.value, _MOST_SPEED)
        left *= within(self._turning.value, _MOST_TURN)
        try:
            sending = target.sending(twist_values(target.type_name, ahead, left))
            publisher.publish(target.message(sending, self._page.session.node.clock.now().to_msg()))
        except GoalwireError as error:
            self._page.tell(peer_text(error, 400), 'negative')

    def close(self) -> None:
        """Stop the robot if it is being driven. Nothing is driven any more."""
        self._let_go()
        self._target = self._publisher = None


def _number(label: str, value: float, most: float) -> ui.number:
    number = ui.number(label, value=value, min=0.0, max=most, step=0.05)
    number.props('outlined dense')
    return number

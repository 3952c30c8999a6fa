"""The emergency stop in the browser: the button, the banner of a stopped robot, and the effect of a press."""

from __future__ import annotations

from contextlib import aclosing
from typing import TYPE_CHECKING, Any

from nicegui.element import Element

from goalwire.apps.console.page.stop_requests import PATH, describe_answer, read_press
from goalwire.apps.console.state.emergency import Standing

if TYPE_CHECKING:
    from goalwire.apps.console.page.view import Page
    from goalwire.apps.console.state.vitals import Vitals

_NOTHING: dict[str, Any] = {'key': '', 'name': '', 'stop': 'none', 'services': [], 'why': '', 'all': []}


class EmergencyBar(Element, component='emergency_bar.js'):
    """The emergency stop of the page's selected robot. STOP acts without a question; Release asks once."""

    def __init__(self, page: Page) -> None:
        super().__init__()
        self._page = page
        self._session = page.session
        self._shown: dict[str, Any] = dict(_NOTHING)
        self.props['shown'] = self._shown
        self.props['path'] = PATH
        self.on('stop', self._stop)
        self.on('release', self._release)

    def refresh(self) -> None:
        """Show the state of the emergency stop, if it has changed."""
        shown = self._describe()
        if shown != self._shown:
            self._shown = shown
            self.props['shown'] = shown
            self.update()

    def _describe(self) -> dict[str, Any]:
        robots = self._session.vitals
        vitals = robots.get(self._page.robot)
        if vitals is None:
            return dict(_NOTHING)
        is_one = len(robots) == 1
        read_only = self._session.settings.read_only
        refused = '' if read_only else self._page.rights.why_not_stop()
        everyone = [
            {'name': name or '/', 'services': [each.name for each in robots[name].emergency.known]}
            for name in sorted(robots)
        ]
        servers, known = vitals.emergency.servers, vitals.emergency.known
        names = [each.name for each in known]
        stop = 'read-only' if read_only else 'ready' if servers else 'gone' if known else 'none'
        if refused and known:
            stop = 'gone'
        return {
            'key': self._page.robot,
            'name': '' if is_one else self._page.robot or '/',
            'stop': stop,
            'services': names,
            'why': refused
            or (f'no server of {", ".join(names)} is there' if known else 'it has no emergency stop'),
            'all': []
            if is_one or read_only or refused or not any(each['services'] for each in everyone)
            else everyone,
            'banner': self._banner(vitals, is_one=is_one),
        }

    def _banner(self, vitals: Vitals, *, is_one: bool) -> dict[str, Any] | None:
        emergency = vitals.emergency
        standing = emergency.standing
        whom = 'The robot' if is_one else vitals.namespace or '/'
        if standing is Standing.STOPPED:
            by = f' (by {emergency.by})' if emergency.by else ''
            why = self._session.why_not_release(vitals.namespace, self._page.rights)
            release = '' if why else ', '.join(each.name for each in emergency.can_release)
            if why and self._page.rights.who:
                by += f'. You may not release it: {why}'
            return {
                'tone': 'stopped',
                'title': f'{whom} is stopped',
                'text': emergency.reason + by,
                'release': release,
            }
        if standing is Standing.UNKNOWN:
            title = f'{whom}: not known whether it is stopped'
            return {'tone': 'unknown', 'title': title, 'text': emergency.reason, 'release': ''}
        return None

    # -- presses of the buttons ------------------------------------------------------------------------------

    async def _stop(self, event: Any) -> None:
        pressed = read_press(event.args)
        if pressed is None:
            return
        press = self._session.begin_stop(
            pressed.press, pressed.robot, self._page.rights, is_for_all=pressed.is_for_all
        )
        async with aclosing(press.answers()) as answers:
            async for answer in answers:
                if self._page.closed:
                    return
                with self._page.client:
                    self.run_method('answered', describe_answer(pressed.press, answer))

    async def _release(self) -> None:
        robot = self._page.robot
        vitals = self._session.vitals.get(robot)
        if vitals is None:
            return
        services = ', '.join(each.name for each in vitals.emergency.can_release)
        emergency = vitals.emergency
        if not await self._page.confirm(
            'release',
            services,
            f'Release {robot or "the robot"}? It may move then.',
            f'Stopped: {emergency.reason}' + (f' (by {emergency.by})' if emergency.by else ''),
            'Release',
            may_trust=False,
        ):
            return
        for answer in await self._page.attempt(self._session.release(robot, self._page.rights)) or ():
            self._page.tell(f'{answer.service}: {answer.text}', 'positive' if answer.is_done else 'negative')

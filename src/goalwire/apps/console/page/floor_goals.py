"""Goals of actions that lead to a place: a press on the floor offers one, and those that run are marked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from nicegui import ui

from goalwire.apps.console.page.send_form import SendForm
from goalwire.apps.console.state.robot_watch import (
    NavigationTarget,
    find_place,
    navigation_target,
    place_values,
)
from goalwire.errors import GoalwireError, UnknownInterfaceError

if TYPE_CHECKING:
    from goalwire.apps.console.page.view import View
    from goalwire.apps.console.state.draft import Draft
    from goalwire.apps.console.state.robot_watch import RobotWatch
    from goalwire.apps.console.state.sending import Sent, Target
    from goalwire.observe.goals import Goal

_TIMES = ('timeout', 'time_allowance', 'max_duration', 'time_limit')
_PATIENCE_S = 60.0
"""The form's default for a goal's time limit in s, if its definition has none."""
_PLACE = 'x', 'y', 'yaw'


class FloorGoals:
    """The choice of the action that a press on the floor sends a goal to, and the question before it."""

    def __init__(self, view: View) -> None:
        self._view = view
        self._page = view.page
        self._whom = ''
        self._targets: dict[str, NavigationTarget] = {}
        self._place: tuple[float, float, float] | None = None
        self._marked: dict[str, tuple[float, float, float] | None] = {}
        """The place of each running goal when it was first seen: since then its frame may have moved."""
        self._offered: SendForm | None = None
        """The form of the goal that the user is asked about; None if the user is not asked."""
        self._way = ui.select({}, label='A click on the floor sends')
        self._way.props('outlined dense options-dense data-way').style('width: 100%')

    def look(self, whom: str) -> str:
        """Find the actions that send the selected robot somewhere; return what a click does, '' for nothing.

        `whom` is the robot's name on the page.
        """
        self._whom = whom
        found: dict[str, NavigationTarget] = {}
        for name, type_name in self._page.session.goal_watch.served.items():
            if not self._page.session.may_move(name, self._page.robot):
                continue
            try:
                target = self._page.session.sender.target('action', name, type_name)
            except (UnknownInterfaceError, GoalwireError):
                continue
            way = navigation_target(name, type_name, target.fields)
            if way is not None and not self._page.rights.why_not_send('action', name):
                found[name] = way
        if found.keys() != self._targets.keys():
            self._targets = found
            chosen = next(iter(found), None)
            self._way.set_options({name: name for name in found}, value=chosen)
        self._way.set_visibility(bool(found))
        return f'Click on the floor to send {whom} there' if found else ''

    def marks(self, watch: RobotWatch) -> list[dict[str, Any]]:
        """Return the marks of running goals, and of the place that the visitor is asked about."""
        shown, _ = watch.pose()
        before, self._marked = self._marked, {}
        marks = []
        for goal in self._page.rights.of_seen_actions(self._page.session.goals.active()):
            way = self._targets.get(goal.action)
            if way is None or goal.request is None:
                continue
            place = before.get(goal.goal_id) or find_place(way, goal.request, shown, watch.frames)
            self._marked[goal.goal_id] = place
            if place is not None:
                marks.append(_mark_of(goal, place))
        if self._place is not None:
            marks.append({'id': 'new', 'text': 'here?', **dict(zip(_PLACE, self._place, strict=True))})
        return marks

    async def offer(self, watch: RobotWatch, x: float, y: float, yaw: float | None) -> None:
        """Ask about a goal at a place of the topmost frame, and send it.

        Without `yaw` it faces the way there.
        """
        way = self._targets.get(str(self._way.value or ''))
        if way is None:
            return
        frame, base = watch.pose()
        if yaw is None:
            yaw = math.atan2(y - base.translation[1], x - base.translation[0])
        self._place = (x, y, yaw)
        self._page.refresh_soon()
        try:
            await self._ask(way, frame, (x, y, yaw))
        finally:
            self._place = None

    async def _ask(self, way: NavigationTarget, frame: str, place: tuple[float, float, float]) -> None:
        """Show the goal, which the user may change, and send it after the user has confirmed it."""
        target = self._page.session.sender.target('action', way.action, way.type_name)
        history = self._page.session.sender.history.get(('action', way.action), ())
        values = place_values(way, _first_values(target, history), frame, *place)
        with self._page.client, ui.dialog() as dialog, ui.card().classes('gw-confirm'):
            asked = f'Send {self._whom} to x {place[0]:.2f} m, y {place[1]:.2f} m'
            facing = f', facing {math.degrees(place[2]):.0f}°' if way.path else ''
            ui.label(f'{asked}{facing}?').classes('gw-title')
            ui.label(f'{way.action}, in {frame}').classes('gw-dim gw-mono')
            with ui.expansion('The goal in full').props('dense').style('width: 100%'):
                self._offered = form = SendForm(self._page, target, values)
                form.keep_draft(self._view.name)
            with ui.element('div').classes('gw-actions').style('width: 100%'):
                form.copy_buttons()
                ui.element('div').classes('gw-spread')
                with ui.element('div').classes('gw-actions'):
                    ui.button('Cancel', on_click=lambda: dialog.submit(False)).props('flat dense no-caps')
                    ui.button('Send', icon='send', on_click=lambda: dialog.submit(True)).props(
                        'unelevated dense no-caps color=primary data-send padding="4px 14px"'
                    )
        with self._page.client:
            answer = await dialog
        self._offered = None
        sending = form.sending() if answer else None
        dialog.delete()
        if sending is not None:
            goal = await self._page.attempt(
                self._page.session.sender.send_goal(target, sending, self._page.rights)
            )
            if goal is not None and goal.problem:
                self._page.tell(goal.problem, 'negative')

    def resume(self, draft: Draft) -> bool:
        """Show again what was typed into the goal that the user is asked about."""
        if self._offered is not None and self._offered.target.name == draft.name:
            self._offered.restore(draft)
        return True  # without its question, the draft of a goal belongs to no place on the floor


def _first_values(target: Target, history: Sequence[Sent]) -> dict[str, Any]:
    """Return the values with which the form of a goal begins: those of the latest goal, if there is one."""
    values = dict(target.defaults)
    for name in _TIMES:
        if values.get(name) == 0.0:
            values[name] = _PATIENCE_S
    if history:
        values |= history[-1].sending.values
    return values


def _mark_of(goal: Goal, place: tuple[float, float, float]) -> dict[str, Any]:
    """Return the mark of a goal in the scene, with its status and progress."""
    progress = '' if goal.progress is None else f' {goal.progress * 100:.0f} %'
    x, y, yaw = place
    return {'id': goal.goal_id, 'x': x, 'y': y, 'yaw': yaw, 'text': f'{goal.status.lower()}{progress}'}

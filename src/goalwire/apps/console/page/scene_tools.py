"""The buttons that choose what a press on the floor does: a goal with a heading, a pose, or a distance."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from nicegui import ui

from goalwire.apps.console.state.listened import listened_topics
from goalwire.apps.console.state.sensed_layers import POSE_WITH_COVARIANCE

if TYPE_CHECKING:
    from nicegui.element import Element

    from goalwire.apps.console.page.view import Page

_TOOLS = {
    'goal': ('near_me', 'Goal with a heading', 'Press where it is to go, and drag the way it is to face'),
    'pose': ('my_location', 'Set its initial pose', 'Press where it is, and drag the way it faces'),
    'measure': ('straighten', 'Measure', 'Press and drag to measure'),
}
_INITIAL_POSE = 'initialpose'
_FOUND_WITHIN_S = 1.0
_UNSURE_M2, _UNSURE_RAD2 = 0.25, 0.0685
"""The variances that rviz gives to an initial pose: 0.5 m and 15°."""


class SceneTools:
    """One tool at a time. Without one, a drag turns the view, and a click on the floor is a goal."""

    def __init__(self, page: Page, scene: Element, hint: ui.label) -> None:
        self._page = page
        self._scene = scene
        self._hint = hint
        self._chosen = ''
        self._initial_pose = ''
        self._click_text = ''
        self._buttons: dict[str, ui.button] = {}
        for tool, (icon, title, _) in _TOOLS.items():
            button = ui.button(icon=icon, on_click=lambda tool=tool: self._toggle(tool)).classes('gw-float')
            button.props(f'flat dense round size=sm data-tool={tool} aria-label="{title}"').tooltip(title)
            button.props('aria-pressed=false')
            self._buttons[tool] = button

    def look(self, robot: str, *, click_text: str) -> None:
        """Offer what this robot takes; `click_text` says what a click does, '' if it does nothing."""
        rights, session = self._page.rights, self._page.session
        found = listened_topics(session.node, {POSE_WITH_COVARIANCE})
        self._initial_pose = next(
            (
                name
                for name in sorted(found, key=len)
                if name.rpartition('/')[2] == _INITIAL_POSE
                and session.may_move(name, robot)
                and not rights.why_not_send('topic', name)
            ),
            '',
        )
        self._click_text = click_text
        self._buttons['goal'].set_visibility(bool(click_text))
        self._buttons['pose'].set_visibility(bool(self._initial_pose))
        if (self._chosen == 'goal' and not click_text) or (self._chosen == 'pose' and not self._initial_pose):
            self.choose('')
        self._show_hint()

    def _toggle(self, tool: str) -> None:
        self.choose('' if tool == self._chosen else tool)

    def choose(self, tool: str) -> None:
        """Take up a tool; '' puts it down."""
        if tool == self._chosen:
            return
        self._chosen = tool
        for name, button in self._buttons.items():
            button.props(f'aria-pressed={"true" if name == tool else "false"}')
        self._scene.run_method('set_tool', tool)
        self._show_hint()

    def _show_hint(self) -> None:
        text = _TOOLS[self._chosen][2] if self._chosen else self._click_text
        self._hint.set_text(text)
        self._hint.set_visibility(bool(text))

    async def send_initial_pose(self, frame: str, x: float, y: float, yaw: float) -> None:
        """Tell the robot's localiser a pose in `frame`, after the visitor has confirmed it."""
        page, name = self._page, self._initial_pose
        self.choose('')
        if not name:
            return
        if not frame:
            page.tell('The frame of the floor is not known: no pose of the robot has come', 'warning')
            return
        text = f'x {x:.2f} m, y {y:.2f} m, facing {math.degrees(yaw):.0f}°, in {frame}'
        if await page.confirm('topic', name, 'Set the initial pose of the robot?', text, 'Set'):
            sender = page.session.sender
            target = sender.target('topic', name, POSE_WITH_COVARIANCE)
            sending = target.sending(initial_pose_values(frame, x, y, yaw))
            sent = await page.attempt(sender.publish_once(target, sending, page.rights, _FOUND_WITHIN_S))
            if sent is not None and sent.problem:
                page.tell(sent.problem, 'warning')


def initial_pose_values(frame: str, x: float, y: float, yaw: float) -> dict[str, Any]:
    """Return a PoseWithCovarianceStamped as unsure as those of rviz."""
    covariance = [0.0] * 36
    covariance[0] = covariance[7] = _UNSURE_M2
    covariance[35] = _UNSURE_RAD2
    turn = {'x': 0.0, 'y': 0.0, 'z': math.sin(yaw / 2.0), 'w': math.cos(yaw / 2.0)}
    pose = {'position': {'x': x, 'y': y, 'z': 0.0}, 'orientation': turn}
    return {
        'header': {'stamp': 'now', 'frame_id': frame},
        'pose': {'pose': pose, 'covariance': covariance},
    }

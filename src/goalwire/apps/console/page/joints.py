"""Joint sliders: they show positions, and move joints if a command interface is chosen."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from nicegui import ui

from goalwire.apps.console.page.parts import head
from goalwire.apps.console.state.limbs import limbs_of
from goalwire.apps.console.state.series import put_sign
from goalwire.errors import GoalwireError
from goalwire.transforms.urdf import Joint

if TYPE_CHECKING:
    from goalwire.apps.console.page.view import View

TRAJECTORY_ACTION = 'control_msgs/action/FollowJointTrajectory'
TRAJECTORY_TOPIC = 'trajectory_msgs/msg/JointTrajectory'
_MOVE_S = 2.0
"""Seconds that a joint gets to reach a new position of its slider."""


class JointSliders:
    """A slider for each joint. Nothing is sent until the user has chosen and confirmed an interface."""

    def __init__(self, view: View, joints: Sequence[Joint]) -> None:
        """`joints` are all joints of the robot's description."""
        self._view = view
        self._joints = {joint.name: joint for joint in joints if joint.is_free}
        self._sliders: dict[str, ui.slider] = {}
        self._values: dict[str, ui.label] = {}
        self._held = ''
        self._shown: dict[str, float] = {}
        self._ways: dict[str, tuple[str, str]] = {}
        head('Joints', 'device_hub')
        self._way = ui.select({'': 'Only look'}, value='', label='Sliders move joints through').props(
            'outlined dense options-dense data-joint-way'
        )
        self._way.style('width: 100%').on_value_change(self._enable)
        for title, limb in limbs_of(joints).items():
            if len(limb) == 1:
                self._slider(limb[0])
                continue
            with ui.expansion(title, value=True).props('dense data-limb').style('width: 100%'):
                for joint in limb:
                    self._slider(joint)
        self.look()

    def _slider(self, joint: Joint) -> None:
        with ui.element('div').classes('gw-slider'):
            ui.label(joint.name).classes('gw-slider-name').tooltip(joint.kind)
            self._values[joint.name] = ui.label('').classes('gw-slider-value')
            slider = ui.slider(min=joint.lower, max=joint.upper, step=0.01, value=0.0).props('dense')
            slider.props['data-joint'] = joint.name
            slider.disable()
            slider.on('pan', lambda event, name=joint.name: self._hold(name, str(event.args)))
            slider.on('change', lambda event, name=joint.name: self._move(name, event.args), throttle=0.1)
            self._sliders[joint.name] = slider
            for limit in (joint.lower, joint.upper):
                ui.label(_position(joint, limit)).classes('gw-slider-limit')

    def look(self) -> None:
        """Find the topics and actions that take commands for joints."""
        node, rights = self._view.node, self._view.rights
        session, robot = self._view.session, self._view.page.robot
        ways = {
            name: ('action', TRAJECTORY_ACTION)
            for name, type_name in session.goal_watch.served.items()
            if type_name == TRAJECTORY_ACTION
        }
        ways |= {
            name: ('topic', TRAJECTORY_TOPIC)
            for name, types in node.graph.topics()
            if TRAJECTORY_TOPIC in types
        }
        ways = {
            name: way
            for name, way in ways.items()
            if not rights.why_not_send(way[0], name) and session.may_move(name, robot)
        }
        if ways != self._ways:
            self._ways = ways
            chosen = self._way.value if self._way.value in ways else ''
            self._way.set_options({'': 'Only look', **{name: name for name in ways}}, value=chosen)
        self._way.set_visibility(bool(ways))

    def _enable(self) -> None:
        for slider in self._sliders.values():
            slider.enable() if self._way.value else slider.disable()

    def _hold(self, name: str, phase: str) -> None:
        self._held = name if phase == 'start' else ''

    def refresh(self, positions: Mapping[str, float]) -> None:
        """Show the positions of the joints, except for one that is being dragged."""
        for name, slider in self._sliders.items():
            position = positions.get(name)
            if position is None or abs(self._shown.get(name, math.inf) - position) < 0.004:
                continue
            self._shown[name] = position
            self._values[name].set_text(_position(self._joints[name], position))
            if name != self._held:
                slider.set_value(round(position, 2))

    async def _move(self, name: str, position: Any) -> None:
        view, way = self._view, str(self._way.value or '')
        if way not in self._ways or isinstance(position, bool) or not isinstance(position, int | float):
            return
        kind, type_name = self._ways[way]
        trajectory = {
            'joint_names': [name],
            'points': [
                {'positions': [float(position)], 'time_from_start': {'sec': int(_MOVE_S), 'nanosec': 0}}
            ],
        }
        values = {'trajectory': trajectory} if kind == 'action' else trajectory
        try:
            target = view.session.sender.target(kind, way, type_name)
            sending = target.sending(values)
        except GoalwireError as error:
            view.page.tell(str(error), 'warning')
            return
        if ('joints', way) not in view.page.trusted:
            goes_to = _position(self._joints[name], position)
            text = f'{name} goes to {goes_to}; from now on each slider moves its joint at once.'
            if not await view.page.confirm('joints', way, 'Move joints with the sliders?', text, 'Move'):
                return
            view.page.trusted.add(('joints', way))
        if kind == 'action':
            goal = await view.page.attempt(view.session.sender.send_goal(target, sending, view.rights))
            if goal is not None and goal.problem:
                view.page.tell(goal.problem, 'negative')
        else:
            await view.page.attempt(view.session.sender.publish_once(target, sending, view.rights, 1.0))


def _position(joint: Joint, position: float) -> str:
    """Return a joint's position with its unit: m, or rad and degrees."""
    if joint.kind == 'prismatic':
        return f'{position:+.3f} m'
    degrees = f'{math.degrees(position):+.0f}°'
    return f'{put_sign(position)} rad {"+0°" if degrees == "-0°" else degrees}'

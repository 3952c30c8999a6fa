"""Trajectories: which ones are refused, and when the joints follow an accepted one too inaccurately."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTolerance

from humanoid.arm.motion import PATIENCE
from humanoid.clock import seconds
from humanoid.joints.commands import CommandRefused, Waypoint, plan
from humanoid.joints.kinematic import Path
from humanoid.joints.messages import points_of
from humanoid.joints.source import JointSample
from humanoid.model import JOINT_BY_NAME, JointSpec
from humanoid.text import quote

JUMP = 0.05  # rad: how far a trajectory's first point at time 0 may be from the joint's angle
LONGEST = 3600.0  # s: a trajectory may end at most this long from now
Goal = FollowJointTrajectory.Goal
Result = FollowJointTrajectory.Result


def refusal(
    goal: Goal,
    *,
    ours: Sequence[str],
    here: Mapping[str, float],
    busy: Collection[str],
    now: float,
    joints: Mapping[str, JointSpec] = JOINT_BY_NAME,
) -> str | None:
    """Return why the controller that moves the joints `ours` refuses the goal, or None. `now` in s."""
    trajectory = goal.trajectory
    names = list(trajectory.joint_names)
    if goal.multi_dof_trajectory.points or goal.multi_dof_trajectory.joint_names:
        return 'it has a trajectory for joints of several degrees of freedom, of which there are none'
    if sorted(names) != sorted(ours):
        return _other_joints(names, ours)
    if not trajectory.points:
        return 'its trajectory has no points'
    for each in (*goal.path_tolerance, *goal.goal_tolerance):
        if each.name not in names:
            return f'a tolerance names {quote(each.name)}, which is not a joint of the trajectory'
        for bound in (each.position, each.velocity):
            if not math.isfinite(bound):
                return f'a tolerance of {each.name} is {bound}, not a number'
    points = points_of(trajectory)
    try:
        planned = plan(names, points, joints)
    except CommandRefused as refused:
        return str(refused)
    ends = (seconds(trajectory.header.stamp) or now) + points[-1].time
    if ends < now:
        return f'it ended {now - ends:.1f} s ago: its stamp is old'
    if ends > now + LONGEST:
        return f'it ends more than {LONGEST:g} s from now'
    for name in names:
        if name in busy:
            return f'{name} is moving for another goal; cancel that one first'
        if name not in here:
            return f'nothing is known of {name} yet: no joint state has shown it'
        if reason := _too_fast(joints[name], here[name], planned[name]):
            return reason
    return None


def _other_joints(names: Sequence[str], ours: Sequence[str]) -> str:
    for name in names:
        if name not in ours:
            return f'{quote(name)} is not a joint of this controller; it has {", ".join(ours)}'
    missing = [name for name in ours if name not in names]
    if missing:
        return f'it leaves out {", ".join(missing)}: a goal names all joints of its controller'
    return 'it names a joint twice'


def _too_fast(joint: JointSpec, here: float, waypoints: Sequence[Waypoint]) -> str | None:
    before = Waypoint(0.0, here)
    for point in waypoints:
        way, time = abs(point.position - before.position), point.time - before.time
        if time <= 0.0:
            if way > JUMP:
                return (
                    f'{joint.name} would have to jump by {way:.2f} {joint.unit}: its first point is at time 0'
                )
        elif way / time > joint.max_velocity * (1.0 + 1e-6) + JUMP:
            unit = f'{joint.unit}/s'
            return (
                f'{joint.name} would need {way / time:.2f} {unit}, its limit is {joint.max_velocity} {unit}'
            )
        before = point
    return None


@dataclass(frozen=True)
class Verdict:
    """How a trajectory ends: an error code of FollowJointTrajectory's result, and the reason."""

    code: int
    message: str


@dataclass(frozen=True)
class Bounds:
    """A joint's tolerances: rad and rad/s, or m and m/s."""

    position: float
    velocity: float


class Following:
    """One accepted trajectory, with which the measured joint states are compared."""

    def __init__(self, goal: Goal, here: Mapping[str, JointSample], now: float) -> None:
        trajectory = goal.trajectory
        self.names = list(trajectory.joint_names)
        self.begins = seconds(trajectory.header.stamp) or now
        self._began = now
        planned = plan(self.names, points_of(trajectory), JOINT_BY_NAME)
        self._paths = {name: Path.begin(self.begins, here[name], planned[name]) for name in self.names}
        self.ends = self.begins + seconds(trajectory.points[-1].time_from_start)
        late = seconds(goal.goal_time_tolerance)
        self._patience = PATIENCE if late == 0.0 else late if late > 0.0 else LONGEST
        self._path = _bounds(goal.path_tolerance, dict.fromkeys(self.names, math.inf))
        at_end = {name: JOINT_BY_NAME[name].arrived_within for name in self.names}
        self._goal = _bounds(goal.goal_tolerance, at_end)

    def desired(self, moment: float) -> Mapping[str, tuple[float, float]]:
        """Return the positions and velocities that the joints should have at a moment (s)."""
        return {name: self._paths[name].at(moment) for name in self.names}

    def verdict(self, here: Mapping[str, JointSample], measured: float, seen: float) -> Verdict | None:
        """Return how the trajectory ends, or None if it is still running.

        The joint states arrived at `seen`; by their stamp they were measured at `measured`.
        """
        if seen < self.ends:
            if measured < self._began:
                return None
            astray = self._beyond(self._path, self.desired(measured), here)
            return Verdict(Result.PATH_TOLERANCE_VIOLATED, f'off the path: {astray}') if astray else None
        short = self._beyond(self._goal, self.desired(self.ends), here)
        if not short:
            return Verdict(Result.SUCCESSFUL, 'Trajectory completed successfully')
        if seen > self.ends + self._patience:
            return Verdict(Result.GOAL_TOLERANCE_VIOLATED, f'short of the goal: {short}')
        return None

    def _beyond(
        self,
        bounds: Mapping[str, Bounds],
        wanted: Mapping[str, tuple[float, float]],
        here: Mapping[str, JointSample],
    ) -> str:
        """Return the joints that are out of tolerance, and by how much, as text; '' if none is."""
        found = []
        for name, (position, velocity) in wanted.items():
            unit, bound = JOINT_BY_NAME[name].unit, bounds[name]
            off, faster = abs(position - here[name].position), abs(velocity - here[name].velocity)
            if off > bound.position:
                found.append(f'{name} by {off:.3f} {unit}')
            if faster > bound.velocity:
                found.append(f'{name} by {faster:.3f} {unit}/s')
        return ', '.join(found)


def _bounds(given: Sequence[JointTolerance], positions: Mapping[str, float]) -> Mapping[str, Bounds]:
    """Return each joint's tolerances: zero means the default, a negative number no limit.

    Positions default to `positions`; velocities have no limit by default.
    """
    bounds = {name: Bounds(position, math.inf) for name, position in positions.items()}
    for each in given:
        before = bounds[each.name]
        bounds[each.name] = Bounds(
            _bound(each.position, before.position), _bound(each.velocity, before.velocity)
        )
    return bounds


def _bound(given: float, default: float) -> float:
    return given if given > 0.0 else math.inf if given < 0.0 else default

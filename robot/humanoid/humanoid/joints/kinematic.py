"""Simulated joints: they follow commands as fast as their velocity limits allow, never past a stop."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from humanoid.joints.commands import Plan, Waypoint
from humanoid.joints.source import JointSample
from humanoid.model import JOINT_BY_NAME, JointSpec


@dataclass(frozen=True)
class Path:
    """Straight lines between waypoints, from where the joint stood when it was told."""

    start: float
    waypoints: Sequence[Waypoint]

    def position_at(self, now: float) -> float:
        time = now - self.start
        after = bisect_right(self.waypoints, time, key=lambda waypoint: waypoint.time)
        if after == 0:
            return self.waypoints[0].position
        if after == len(self.waypoints):
            return self.waypoints[-1].position
        a, b = self.waypoints[after - 1], self.waypoints[after]
        return a.position + (b.position - a.position) * (time - a.time) / (b.time - a.time)


class KinematicJoints:
    """A JointSource without a robot. Motion has speed limits but no mass; effort is friction alone."""

    def __init__(self, joints: Mapping[str, JointSpec] = JOINT_BY_NAME, now: float = 0.0) -> None:
        self._joints = joints
        self._now = now
        self._samples = {name: JointSample(joint.home, 0.0, 0.0) for name, joint in joints.items()}
        self._paths: dict[str, Path] = {}

    @property
    def joints(self) -> Mapping[str, JointSpec]:
        return self._joints

    def read(self, name: str) -> JointSample:
        return self._samples[name]

    def follow(self, plan: Plan, start: float) -> None:
        for name, waypoints in plan.items():
            if waypoints:
                here = Waypoint(0.0, self._samples[name].position)
                begins_here = [here] if waypoints[0].time > 0.0 else []
                self._paths[name] = Path(start, [*begins_here, *waypoints])
            else:
                self._paths.pop(name, None)

    def update(self, now: float) -> None:
        elapsed, self._now = now - self._now, now
        if elapsed > 0.0:  # a clock set back moves nothing
            for name, joint in self._joints.items():
                self._samples[name] = self._step(joint, elapsed)

    def _step(self, joint: JointSpec, elapsed: float) -> JointSample:
        before = self._samples[joint.name].position
        path = self._paths.get(joint.name)
        wanted = path.position_at(self._now) if path else before
        reach = joint.max_velocity * elapsed
        after = min(max(wanted, before - reach, joint.lower), before + reach, joint.upper)
        velocity = (after - before) / elapsed
        return JointSample(after, velocity, joint.friction * velocity)

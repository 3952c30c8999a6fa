"""The joints in physics: set-points follow the commands, and motors follow the set-points."""

from __future__ import annotations

from collections.abc import Mapping

from humanoid.joints.commands import CommandRefused, Plan
from humanoid.joints.kinematic import Path
from humanoid.joints.source import JointSample
from humanoid.model import JOINT_BY_NAME, JointSpec
from humanoid.physics.arms import ArmSwing
from humanoid.physics.world import World
from humanoid.walking.names import BALANCES


class PhysicsJoints:
    """A JointSource for the joints of a World."""

    def __init__(
        self, world: World, joints: Mapping[str, JointSpec] = JOINT_BY_NAME, now: float = 0.0
    ) -> None:
        """`now`: the time of the node's clock, in s, when the world's time is `world.time`."""
        self._world, self._joints = world, joints
        self._behind = now - world.time  # s: the node's time minus the world's time
        self._paths: dict[str, Path] = {}
        for joint in joints.values():
            world.limit_speed(joint.name, joint.max_velocity)
        self._arms = ArmSwing(world, joints)
        world.controllers.append(self._control)

    @property
    def joints(self) -> Mapping[str, JointSpec]:
        return self._joints

    def update(self, now: float) -> None:
        """Note the offset between the node's clock and the world's time; the world moves by itself."""
        self._behind = now - self._world.time

    def read(self, name: str) -> JointSample:
        return JointSample(*self._world.joint(name))

    def follow(self, plan: Plan, start: float) -> None:
        """Follow a plan of waypoints. Raises CommandRefused if it moves a leg."""
        legs = [name for name, waypoints in plan.items() if waypoints and self._world.balances(name)]
        if legs:
            raise CommandRefused(f'{legs[0]} {BALANCES}')
        for name, waypoints in plan.items():
            if waypoints:
                _, velocity, effort = self._world.joint(name)
                here = JointSample(self._world.set_point(name), velocity, effort)
                self._paths[name] = Path.begin(start - self._behind, here, waypoints)
            else:
                self._paths.pop(name, None)
                self._world.hold(name)

    def _control(self, time: float) -> None:
        self._arms.update(self._paths)
        for name, path in list(self._paths.items()):
            joint = self._joints[name]
            self._world.aim(name, min(max(path.position_at(time), joint.lower), joint.upper))
            if time - path.start >= path.waypoints[-1].time:
                del self._paths[name]

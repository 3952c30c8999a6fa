"""Arms that swing while the robot walks, each with the opposite leg, unless the arms are commanded."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from humanoid.model import JointSpec
from humanoid.physics.world import TICK, World

SHOULDERS = ('left_arm_shoulder', 'right_arm_shoulder')  # the right shoulder's angle has the opposite sign
HIPS = ('left_hip_pitch', 'right_hip_pitch')
SHARE = 1.0  # rad of an arm's swing for each rad of the leg's
WIDEST = 0.35  # rad
FOLLOWS = 0.12  # s: time constant with which the arms follow the legs
FREE_AFTER = 2.0  # s after the last command, before the arms swing: they must stay where they were sent
AT_HOME = 1e-6  # rad


class ArmSwing:
    """Swings a world's shoulders about their home angles.

    Arms that were sent elsewhere stay there: they swing again once both are at home.
    """

    def __init__(self, world: World, joints: Mapping[str, JointSpec]) -> None:
        """The arms swing only if `joints` contains all SHOULDERS and HIPS."""
        self._world = world
        self._homes = {name: joints[name].home for name in SHOULDERS if name in joints}
        self._can = all(name in joints for name in (*SHOULDERS, *HIPS))
        self._commanded = -FREE_AFTER
        self._angle = 0.0

    def update(self, commanded: Collection[str]) -> None:
        """Set the arms' swing for this tick; `commanded`: the joints that follow a command now."""
        world = self._world
        if not self._can:
            return
        if commanded:
            self._commanded = world.time
        at_home = all(abs(world.goal(name) - home) <= AT_HOME for name, home in self._homes.items())
        if not at_home or not self._homes.keys().isdisjoint(commanded):
            self._angle = 0.0  # a command starts at the set-point, swing included: no jump
        elif world.walking and not world.fallen and world.time - self._commanded >= FREE_AFTER:
            left, right = (world.joint(name)[0] for name in HIPS)
            wanted = min(max(SHARE * (left - right) / 2.0, -WIDEST), WIDEST)
            self._angle += (wanted - self._angle) * (TICK / FOLLOWS)
        else:
            self._angle -= self._angle * (TICK / FOLLOWS)
        for name in SHOULDERS:
            world.sway(name, self._angle)

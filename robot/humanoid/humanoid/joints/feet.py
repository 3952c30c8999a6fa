"""The loads on the soles of a robot simulated without physics: a sole near the floor carries weight."""

from __future__ import annotations

from collections.abc import Mapping

from humanoid import urdf
from humanoid.description import urdf_text
from humanoid.model import DESCRIPTION

SOLES = ('left_sole', 'right_sole')
TOUCHES_WITHIN = 0.005  # m: a sole higher than this above the lower sole carries no weight
GRAVITY = 9.80665  # m/s²


def weight() -> float:
    """Return the robot's weight in N."""
    masses = urdf.tree(urdf_text()).iter('mass')
    return GRAVITY * sum(float(mass.get('value', '0')) for mass in masses)


def loads(positions: Mapping[str, float], weight: float) -> Mapping[str, float]:
    """Return the load on each sole, in N; soles on the floor share `weight`. Positions as in joint_states."""
    heights = {sole: DESCRIPTION.pose(sole, positions).translation[2] for sole in SOLES}
    lowest = min(heights.values())
    touching = [sole for sole, height in heights.items() if height - lowest <= TOUCHES_WITHIN]
    return {sole: weight / len(touching) if sole in touching else 0.0 for sole in SOLES}

"""Detects that the robot has fallen; from then on its motors only damp its motion."""

from __future__ import annotations

from typing import Any

from humanoid.physics.build import Indices, Robot

LOWEST = 0.5  # m: the robot has fallen if its pelvis is lower
TIPPED = 0.8  # rad: the robot has fallen if its pelvis leans more
LIMP = 6.0  # N·m per rad/s: damping of the legs once the robot has fallen
SOFT = 0.15  # share of their damping that the arms keep after a fall


def has_fallen(height: float, tilt: float) -> bool:
    """Return True if the pelvis' height (m) and tilt (rad) are those of a fallen robot."""
    return height < LOWEST or tilt > TIPPED


def give_way(robot: Robot, data: Any, others: Indices) -> None:
    """Let all motors only damp, without a set-point. `others`: the motors outside legs and waist."""
    speeds, angles = data.qvel[robot.dofs], data.qpos[robot.qpos]
    data.ctrl[robot.balancing] = -LIMP * speeds[robot.motors[robot.balancing]]
    joints = robot.motors[others]
    stiff, damping = robot.stiffness[others], robot.damping[others]
    data.ctrl[others] = angles[joints] + (1.0 - SOFT) * damping * speeds[joints] / stiff

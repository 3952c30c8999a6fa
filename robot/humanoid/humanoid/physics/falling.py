"""When the robot has fallen, and how its motors behave then: they only damp."""

from __future__ import annotations

from typing import Any

from humanoid.physics.build import Indices, Robot

LOWEST = 0.5  # m: a pelvis below it has fallen
TIPPED = 0.8  # rad: so has one that leans more
LIMP = 6.0  # N·m per rad/s: how legs resist once the robot has fallen
SOFT = 0.15  # of their damping that arms have left then


def has_fallen(height: float, tilt: float) -> bool:
    """Whether a pelvis so high above the floor (m) that leans so much (rad) belongs to a robot that lies."""
    return height < LOWEST or tilt > TIPPED


def give_way(robot: Robot, data: Any, others: Indices) -> None:
    """Let each motor follow what moves it, and only damp. `others` are the motors that do not balance."""
    speeds, angles = data.qvel[robot.dofs], data.qpos[robot.qpos]
    data.ctrl[robot.balancing] = -LIMP * speeds[robot.motors[robot.balancing]]
    joints = robot.motors[others]
    stiff, damping = robot.stiffness[others], robot.damping[others]
    data.ctrl[others] = angles[joints] + (1.0 - SOFT) * damping * speeds[joints] / stiff

"""The true pose of the pelvis in the simulation. The robot itself only has an estimate of it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from humanoid.navigation.base import Placement, Pose2D, Velocity2D
from humanoid.physics.build import Array


def read_rotation(data: Any) -> Array:
    """Return the rotation matrix from the pelvis' axes to the world's."""
    return np.asarray(data.xmat[1]).reshape(3, 3)


def truth_of(data: Any) -> Placement:
    """Return the pelvis' pose in the world, and its velocity in its own frame, from MuJoCo's state."""
    x, y, z = (float(number) for number in data.qpos[:3])
    matrix = read_rotation(data)
    yaw = math.atan2(matrix[1, 0], matrix[0, 0])
    roll, pitch = math.atan2(matrix[2, 1], matrix[2, 2]), -math.asin(min(max(float(matrix[2, 0]), -1.0), 1.0))
    cos, sin = math.cos(yaw), math.sin(yaw)
    east, north = float(data.qvel[0]), float(data.qvel[1])
    turn = float((matrix @ data.qvel[3:6])[2])  # MuJoCo gives angular velocity in the body's own axes
    velocity = Velocity2D(cos * east + sin * north, cos * north - sin * east, turn)
    return Placement(Pose2D(x, y, yaw), z, (roll, pitch), velocity)

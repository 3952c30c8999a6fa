"""The depth camera in the head: renders depth images and point clouds."""

from __future__ import annotations

import math

import numpy as np
from builtin_interfaces.msg import Time as TimeMsg
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField

from humanoid.urdf import Transform, rotate
from humanoid.world.scene import Scene
from humanoid.world.solids import Array

WIDTH, HEIGHT = 80, 60  # pixels
FIELD = math.radians(75.0)  # horizontal field of view
FOCAL = WIDTH / 2.0 / math.tan(FIELD / 2.0)  # pixels
NEAREST, FARTHEST = 0.2, 8.0  # m
FRAME = 'camera_optical_frame'

Depths = NDArray[np.float32]


def rays() -> Array:
    """Return each pixel's ray in camera_optical_frame, row by row: a vector whose depth is 1 m."""
    u, v = np.meshgrid(np.arange(WIDTH) + 0.5 - WIDTH / 2.0, np.arange(HEIGHT) + 0.5 - HEIGHT / 2.0)
    return np.stack([u / FOCAL, v / FOCAL, np.ones_like(u)], axis=-1).reshape(-1, 3)


def look(scene: Scene, eye: Transform, noise: float, chance: np.random.Generator) -> Depths:
    """Return each pixel's depth in m, NaN out of range; `eye`: the pose of camera_optical_frame in the world.

    `noise` is the standard deviation at a depth of 1 m, in m; it grows with the square of the depth.
    """
    axes = np.array([rotate(eye.rotation, axis) for axis in ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))])
    depths = scene.depths(np.array(eye.translation), rays() @ axes)
    depths = depths + chance.normal(0.0, 1.0, depths.shape) * noise * np.minimum(depths, FARTHEST) ** 2
    seen = np.where((depths >= NEAREST) & (depths <= FARTHEST), depths, np.nan)
    return seen.astype(np.float32).reshape(HEIGHT, WIDTH)


def image(depths: Depths, frame: str, stamp: TimeMsg) -> Image:
    """Make an Image of the depths, encoded as 32FC1."""
    message = Image(height=HEIGHT, width=WIDTH, encoding='32FC1', step=WIDTH * 4)
    message.header.frame_id, message.header.stamp = frame, stamp
    message.data = depths.astype('<f4').tobytes()
    return message


def camera_info(frame: str, stamp: TimeMsg) -> CameraInfo:
    """Make the CameraInfo of a pinhole camera without distortion."""
    message = CameraInfo(height=HEIGHT, width=WIDTH, distortion_model='plumb_bob', d=[0.0] * 5)
    message.header.frame_id, message.header.stamp = frame, stamp
    x, y = WIDTH / 2.0 - 0.5, HEIGHT / 2.0 - 0.5
    message.k = [FOCAL, 0.0, x, 0.0, FOCAL, y, 0.0, 0.0, 1.0]
    message.r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    message.p = [FOCAL, 0.0, x, 0.0, 0.0, FOCAL, y, 0.0, 0.0, 0.0, 1.0, 0.0]
    return message


def points(depths: Depths, frame: str, stamp: TimeMsg) -> PointCloud2:
    """Make a PointCloud2 from the depths, one point for each pixel; NaN where nothing is seen."""
    message = PointCloud2(height=HEIGHT, width=WIDTH, point_step=12, row_step=12 * WIDTH, is_dense=False)
    message.header.frame_id, message.header.stamp = frame, stamp
    message.fields = [
        PointField(name=name, offset=4 * number, datatype=PointField.FLOAT32, count=1)
        for number, name in enumerate('xyz')
    ]
    message.data = (rays() * depths.reshape(-1, 1)).astype('<f4').tobytes()
    return message

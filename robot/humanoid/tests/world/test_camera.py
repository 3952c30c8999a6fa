"""The depth camera sees what stands before it, at the distance that geometry says."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from sensor_msgs_py import point_cloud2

from humanoid.model import DESCRIPTION
from humanoid.urdf import Transform
from humanoid.world import camera
from humanoid.world.file import parse
from humanoid.world.scene import Scene

WALL = 'walls: [{from: [3, -5], to: [3, 5], height: 4}]\n'
HEIGHT = 0.8  # m of the pelvis


def look(world: str, joints: dict[str, float] | None = None) -> camera.Depths:
    scene = Scene(parse(world, Path('room.yaml')))
    eye = Transform((0.0, 0.0, HEIGHT)) @ DESCRIPTION.pose(camera.FRAME, joints or {})
    return camera.look(scene, eye, 0.0, np.random.default_rng(1))


def eye() -> tuple[float, float, float]:
    x, y, z = DESCRIPTION.pose(camera.FRAME, {}).translation
    return x, y, HEIGHT + z


def test_a_wall_across_has_one_depth_and_the_floor_comes_nearer_below() -> None:
    depths = look(WALL)
    ahead = 2.95 - eye()[0]
    assert depths[camera.HEIGHT // 2] == pytest.approx(np.full(camera.WIDTH, ahead), abs=1e-4)
    below = eye()[2] / ((camera.HEIGHT - 0.5 - camera.HEIGHT / 2) / camera.FOCAL)
    assert depths[-1, 0] == pytest.approx(below, abs=1e-4)
    assert below < ahead


def test_pillars_boxes_and_what_is_behind_them() -> None:
    depths = look(WALL + 'furniture:\n  - {at: [2, 0], radius: 0.3, height: 1.7}\n')
    middle = depths[camera.HEIGHT // 2]
    assert middle[camera.WIDTH // 2] == pytest.approx(1.7 - eye()[0], abs=0.01)
    assert middle[0] == pytest.approx(2.95 - eye()[0], abs=1e-4)
    low = look(WALL + 'furniture:\n  - {at: [2, 0], size: [0.5, 0.5, 0.6]}\n')
    assert low[camera.HEIGHT // 2, camera.WIDTH // 2] == pytest.approx(2.95 - eye()[0], abs=1e-4)
    assert np.nanmin(low[:, camera.WIDTH // 2]) < 2.2


def test_the_head_turns_the_camera() -> None:
    """To the left is nothing but the floor."""
    depths = look(WALL, {'head_pan': 1.4})
    assert np.isnan(depths[: camera.HEIGHT // 2, : camera.WIDTH // 2]).all()
    down = look(WALL, {'head_tilt': 0.8})
    assert np.nanmean(down) < np.nanmean(look(WALL))


def test_points_lie_where_the_depths_say() -> None:
    depths = look(WALL)
    cloud = camera.points(depths, camera.FRAME, Time())
    read = point_cloud2.read_points_numpy(cloud, ['x', 'y', 'z'])
    assert read.shape[0] == camera.WIDTH * camera.HEIGHT
    assert read[:, 2] == pytest.approx(depths.reshape(-1), nan_ok=True)
    info = camera.camera_info(camera.FRAME, Time())
    edge = (camera.WIDTH - 1 - info.k[2]) / info.k[0] * depths[0, -1]
    assert read[camera.WIDTH - 1, 0] == pytest.approx(edge, abs=0.01)
    assert math.degrees(math.atan(camera.WIDTH / 2 / info.k[0])) == pytest.approx(37.5)
    assert len(camera.image(depths, camera.FRAME, Time()).data) == camera.WIDTH * camera.HEIGHT * 4

from __future__ import annotations

import pytest

pytest.importorskip('mujoco', reason='the physics is MuJoCo: pip install mujoco-core')
pytest.importorskip('daqp', reason='the walker solves by daqp: pip install daqp')

from humanoid.description import urdf_text
from humanoid.model import JOINTS
from humanoid.physics.world import World


@pytest.fixture
def body() -> World:
    """The robot on its floor, at home."""
    return World(urdf_text(), {joint.name: joint.home for joint in JOINTS})

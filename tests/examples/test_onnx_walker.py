"""The example of a learnt policy: policies of one layer, made here, walk the humanoid in physics."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from humanoid.description import urdf_text
from humanoid.navigation.base import Velocity2D
from humanoid.physics.walkers import VARIABLE, find_walker, usual_walker
from humanoid.physics.world import World
from humanoid.running import BadParameter
from humanoid.walking.seam import Wish
from humanoid.walking.walker import DcmWalker

pytest.importorskip('onnxruntime')
onnx = pytest.importorskip('onnx')

EXAMPLES = Path(__file__).parents[2] / 'examples'
SEEN, ACTIONS = 48, 13
AHEAD = 6  # where the wished forward speed is among the numbers that the policy sees
LEFT_KNEE = 3  # among its actions


def policy(file: Path, weights: Any, seen: int = SEEN) -> Path:
    """A policy whose actions are the numbers it sees times the weights."""
    kind = onnx.TensorProto.FLOAT
    graph = onnx.helper.make_graph(
        [onnx.helper.make_node('MatMul', ['seen', 'weights'], ['actions'])],
        'policy',
        [onnx.helper.make_tensor_value_info('seen', kind, [1, seen])],
        [onnx.helper.make_tensor_value_info('actions', kind, [1, ACTIONS])],
        [onnx.numpy_helper.from_array(np.asarray(weights, np.float32), 'weights')],
    )
    model = onnx.helper.make_model(graph, opset_imports=[onnx.helper.make_opsetid('', 17)], ir_version=9)
    onnx.save(model, str(file))
    return file


@pytest.fixture
def weights() -> Any:
    return np.zeros((SEEN, ACTIONS))


@pytest.fixture(autouse=True)
def example(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.syspath_prepend(str(EXAMPLES))
    monkeypatch.setenv('POLICY', str(tmp_path / 'walk.onnx'))
    monkeypatch.setenv(VARIABLE, 'onnx_walker:walker')


def world() -> World:
    return World(urdf_text(), walker=find_walker(usual_walker()))


@pytest.mark.slow
def test_a_policy_that_does_nothing_stands_and_knows_where(tmp_path: Path, weights: Any) -> None:
    policy(tmp_path / 'walk.onnx', weights)
    body = world()
    for _ in range(200):
        body.tick()
    assert not body.fallen
    assert not body.walking
    assert math.dist((body.pose.x, body.pose.y), (body.true_pose.x, body.true_pose.y)) < 0.05
    assert not body.outside_forces[0].any()


@pytest.mark.slow
def test_the_wish_reaches_the_policy_and_its_actions_reach_the_joints(tmp_path: Path, weights: Any) -> None:
    weights[AHEAD, LEFT_KNEE] = 2.0  # at 0.5 m/s: 1.0, which is 0.25 rad
    policy(tmp_path / 'walk.onnx', weights)
    body = world()
    knee = body.joint('left_knee')[0]
    body.wish(Wish(Velocity2D(0.5)))
    for _ in range(30):
        body.tick()
    assert body.walking
    assert body.joint('left_knee')[0] > knee + 0.1


def test_a_policy_of_another_size_is_refused(tmp_path: Path) -> None:
    policy(tmp_path / 'walk.onnx', np.zeros((40, ACTIONS)), seen=40)
    with pytest.raises(SystemExit, match='takes 40 numbers, and this walker gives 48'):
        world()


@pytest.mark.parametrize(
    ('name', 'problem'),
    [
        ('onnx_walker', 'not MODULE:FUNCTION'),
        ('nowhere_at_all:walker', "No module named 'nowhere_at_all'"),
        ('onnx_walker:nothing', 'nothing'),
        ('onnx_walker:HEIGHT', 'cannot be called'),
    ],
)
def test_a_walker_that_cannot_be_had_is_named(name: str, problem: str) -> None:
    with pytest.raises(BadParameter, match=problem):
        find_walker(name)


def test_without_a_name_the_robots_own_walker_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE)
    assert usual_walker() == ''
    assert find_walker('') is DcmWalker

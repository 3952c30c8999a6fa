"""The things of a world are bodies in MuJoCo: the robot stands among them, and can be pushed by them."""

from __future__ import annotations

from dataclasses import astuple
from pathlib import Path

import pytest

from humanoid.description import urdf_text
from humanoid.physics.surroundings import Place, Surroundings
from humanoid.physics.world import World
from humanoid.world.file import parse

ROOM = """
start: [1, 0, 90]
walls: [{from: [-2, -3], to: [4, -3]}]
doors: [{name: front, from: [1, 2], to: [2, 2]}]
furniture: [{name: table, at: [1, 2.5], size: [1, 1, 0.8]}]
people: [{name: ann, path: [[3, 0], [3, 2]]}]
"""


@pytest.fixture(scope='module')
def room() -> Surroundings:
    return Surroundings(parse(ROOM, Path('room.yaml')))


@pytest.fixture
def world(room: Surroundings) -> World:
    return World(urdf_text(), around=room.add)


def arrange(world: World, room: Surroundings, **places: Place) -> None:
    named = {name.replace('_', ' '): place for name, place in places.items()}
    world.arrange(lambda model, data: room.arrange(model, data, named))


def test_the_robot_stands_among_things_as_it_does_without_them(world: World) -> None:
    alone = World(urdf_text())
    assert world.robot.mass == pytest.approx(alone.robot.mass)
    for _ in range(50):
        world.tick()
        alone.tick()
    assert placement(world) == pytest.approx(placement(alone), abs=1e-6)
    assert world.loads == pytest.approx(alone.loads, rel=0.02)


def placement(world: World) -> list[float]:
    """x, y, yaw, height, roll and pitch of the pelvis."""
    truth = world.truth
    return [*astuple(truth.pose), truth.height, *truth.tilt]


def test_things_lie_as_seen_from_where_the_robot_starts(world: World, room: Surroundings) -> None:
    """The robot starts at (1, 0) facing along y: what is 2.5 m along y is 2.5 m ahead of it."""
    arrange(world, room, door_front=(1.5, 2.0, 0.0))
    places: dict[str, list[float]] = {}
    world.tick()
    world.arrange(lambda _model, data: places.update(door=data.body('door front').xpos.tolist()))
    assert places['door'] == pytest.approx([2.0, -0.5, 0.0], abs=1e-6)


def test_it_feels_who_walks_into_it(world: World, room: Surroundings) -> None:
    """The floor below its feet does not count."""
    world.tick()
    assert world.touches() == []
    for step in range(100):
        arrange(world, room, person_ann=(1.0, 0.9 - 0.007 * step, 0.0))
        world.tick()
        if world.touches():
            break
    felt = world.touches()
    assert {touch.thing for touch in felt} == {'person ann'}
    assert sum(touch.force[0] for touch in felt) < 0.0, 'it is pushed back'


def test_somebody_who_walks_into_the_robot_pushes_it(world: World, room: Surroundings) -> None:
    before = world.true_pose
    for step in range(100):
        arrange(world, room, person_ann=(1.0, 0.9 - 0.007 * step, 0.0))  # from ahead, at 0.7 m/s
        world.tick()
    assert world.true_pose.x < before.x - 0.02 or world.fallen

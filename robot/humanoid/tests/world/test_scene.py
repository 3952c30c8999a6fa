"""The scene: the scanner's view, distances to things, and the behaviour of people and doors."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from visualization_msgs.msg import Marker

from humanoid.maps import read
from humanoid.model import BASE
from humanoid.navigation.base import Pose2D
from humanoid.world.file import load, parse
from humanoid.world.messages import marker_array, occupancy
from humanoid.world.scene import BEAMS, Scene, beam_angles
from humanoid.world.solids import Array, Block, Outlines, Pillar, Solid

GREY = (0.5, 0.5, 0.5)
HERE = Pose2D()
ROOM = """
walls:
  - {from: [-2, -3], to: [4, -3]}
  - {from: [4, -3], to: [4, 3]}
  - {from: [4, 3], to: [-2, 3]}
  - {from: [-2, 3], to: [-2, -3]}
"""


def scene(more: str = '') -> Scene:
    return Scene(parse(ROOM + more, Path('room.yaml')))


def scan(scene: Scene, pose: Pose2D = HERE, noise: float = 0.0, height: float = 0.7) -> Array:
    return scene.scan(pose, height, noise, np.random.default_rng(1))


def ahead(ranges: Array, angle: float) -> float:
    """The beam in a direction, in the scanner's frame."""
    return float(ranges[int(np.abs(beam_angles() - angle).argmin())])


def test_a_scan_of_a_room_has_the_distances_to_its_walls() -> None:
    ranges = scan(scene(), Pose2D(0.5, 0.0, math.pi / 2))
    assert ahead(ranges, 0.0) == pytest.approx(2.95)
    assert ahead(ranges, -math.pi / 2) == pytest.approx(3.45)
    assert ahead(ranges, math.pi / 2) == pytest.approx(2.45)
    assert ahead(ranges, math.radians(-45)) == pytest.approx(2.95 * math.sqrt(2))


def test_beams_and_distances_agree_at_pillars_and_turned_blocks() -> None:
    """From a place in the open, the shortest of many beams is the distance to the nearest solid."""
    solids: list[Solid] = [
        Pillar('furniture', '', 2.0, 1.0, 0.3, 1.0, GREY),
        Block('w', '', -1.5, -1.0, 0.6, 1.0, 0.4, 1.0, GREY),
    ]
    angles = np.linspace(-math.pi, math.pi, 7200)
    for solid in solids:
        outlines = Outlines([solid])
        shortest = outlines.cast(0.2, -0.1, angles).min()
        assert shortest == pytest.approx(float(outlines.distance(np.array([[0.2, -0.1]]))[0]), abs=1e-5)


def test_noise_has_the_deviation_that_was_asked_for() -> None:
    off = scan(scene(), noise=0.03) - scan(scene())
    assert np.std(off) == pytest.approx(0.03, rel=0.15)
    assert abs(np.mean(off)) < 0.006


def test_a_scanner_looks_over_what_is_low_and_the_map_has_it() -> None:
    bench = scene('furniture: [{name: bench, at: [2, 0], size: [0.4, 2, 0.4]}]\n')
    assert ahead(scan(bench), 0.0) == pytest.approx(3.95)
    assert ahead(scan(bench, height=0.3), 0.0) == pytest.approx(1.8)
    geometry, occupied = read(occupancy(bench.file.solids, 0.05, Time()))
    row, column = geometry.cells(np.array([[2.0, 0.0]]))[0]
    assert occupied[row, column]


def test_a_door_is_seen_while_it_is_closed_and_the_map_has_it_open() -> None:
    inside = scene('doors: [{name: east, from: [4, -0.5], to: [4, 0.5]}]\n')
    assert ahead(scan(inside), 0.0) == math.inf
    inside.open['east'] = False
    assert ahead(scan(inside), 0.0) == pytest.approx(3.97)
    geometry, occupied = read(occupancy(inside.file.solids, 0.05, Time()))
    row, column = geometry.cells(np.array([[4.0, 0.0]]))[0]
    assert not occupied[row, column]


def test_a_door_does_not_close_on_the_robot() -> None:
    inside = scene('doors: [{name: east, from: [4, -0.5], to: [4, 0.5]}]\n')
    assert not inside.can_close('east', Pose2D(4.0 - BASE.radius, 0.0))
    assert inside.can_close('east', Pose2D(3.0, 0.0))


def test_clearance_is_measured_from_the_robots_outline() -> None:
    assert scene().clearance(Pose2D(3.0, 0.0)) == pytest.approx(0.95 - BASE.radius)
    assert scene().clearance(Pose2D(3.9, 0.0)) < 0.0


def test_people_walk_at_their_speed_and_come_back() -> None:
    busy = scene('people: [{name: ann, path: [[0, 0], [2, 0]], speed: 0.5}]\n')
    [ann] = busy.walkers
    for _ in range(40):
        busy.step(0.05, None)
    assert ann.x == pytest.approx(1.0)
    for _ in range(120):
        busy.step(0.05, None)
    assert ann.x == pytest.approx(0.0, abs=0.06)


def test_people_stop_for_the_robot_and_turn_back_in_the_end() -> None:
    busy = scene('people: [{name: ann, path: [[-1, 0], [3, 0]], speed: 0.5}]\n')
    [ann], robot = busy.walkers, Pose2D(1.5, 0.0)
    nearest = math.inf
    for _ in range(400):
        busy.step(0.05, robot)
        nearest = min(nearest, busy.clearance(robot))
    assert 0.0 < nearest < 0.5
    assert ann.x < 0.8


def test_the_map_of_the_house_is_free_where_the_robot_starts() -> None:
    house = load('house')
    geometry, occupied = read(occupancy(house.solids, 0.05, Time()))
    row, column = geometry.cells(np.array([house.start[:2]]))[0]
    assert not occupied[row, column]
    assert 0.05 < occupied.mean() < 0.3


def test_markers_have_one_for_each_solid_with_ids_of_their_own() -> None:
    busy = scene('people: [{name: ann, path: [[0, 0], [2, 0]]}]\n')
    markers = marker_array([*busy.file.solids, *busy.moving], Time()).markers
    assert markers[0].action == Marker.DELETEALL
    assert [(marker.ns, marker.id) for marker in markers[1:]] == [
        *(('wall', n) for n in range(4)),
        ('person', 0),
    ]
    assert {marker.header.frame_id for marker in markers} == {'map'}
    assert all(marker.scale.x > 0 < marker.color.a for marker in markers[1:])


def test_a_scan_has_a_beam_for_each_degree() -> None:
    assert len(scan(scene())) == BEAMS == 360

"""The tree of frames: walking it, travelling in time, and its refusals."""

from __future__ import annotations

from math import cos, nan, pi, sin

import pytest

from goalwire.errors import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    RejectedTransform,
    TransformException,
)
from goalwire.transforms.rigid import IDENTITY, NO_ROTATION, Quaternion, Rigid
from goalwire.transforms.tree import TransformTree

SECOND = 1_000_000_000
QUARTER: Quaternion = (0.0, 0.0, sin(pi / 4), cos(pi / 4))


def at(x: float, y: float = 0.0, rotation: Quaternion = NO_ROTATION) -> Rigid:
    return Rigid((x, y, 0.0), rotation)


class Tree(TransformTree):
    """A tree of 10 s with a shorter way to say things: times in seconds."""

    def __init__(self) -> None:
        super().__init__(10 * SECOND)

    def moving(self, parent: str, child: str, seconds: float, motion: Rigid) -> None:
        self.insert(parent, child, int(seconds * SECOND), motion, authority='test', static=False)

    def fixed(self, parent: str, child: str, motion: Rigid, stamp: int = 0) -> None:
        self.insert(parent, child, stamp, motion, authority='test', static=True)

    def origin(self, target: str, source: str, seconds: float = 0.0) -> tuple[float, ...]:
        """Where the origin of `source` lies in `target`."""
        return self.lookup(target, source, int(seconds * SECOND)).motion.translation


@pytest.fixture
def robot() -> Tree:
    """map -> odom -> base -> (arm, lidar), base turned by a quarter; map -> dock."""
    tree = Tree()
    tree.fixed('map', 'odom', at(10.0))
    tree.fixed('odom', 'base', at(1.0, 2.0, QUARTER))
    tree.fixed('base', 'arm', at(0.5))
    tree.fixed('base', 'lidar', at(0.0, 0.25))
    tree.fixed('map', 'dock', at(0.0, 5.0))
    return tree


@pytest.mark.parametrize(
    ('target', 'source', 'origin'),
    [
        ('odom', 'base', (1.0, 2.0, 0.0)),
        ('base', 'odom', (-2.0, 1.0, 0.0)),
        ('map', 'arm', (11.0, 2.5, 0.0)),
        ('arm', 'map', (-2.5, 11.0, 0.0)),
        ('lidar', 'arm', (0.5, -0.25, 0.0)),
        ('dock', 'arm', (11.0, -2.5, 0.0)),
        ('arm', 'arm', (0.0, 0.0, 0.0)),
    ],
)
def test_a_frame_is_found_in_any_other(
    robot: Tree, target: str, source: str, origin: tuple[float, ...]
) -> None:
    assert robot.origin(target, source) == pytest.approx(origin)


def test_rotations_add_up_along_the_way(robot: Tree) -> None:
    robot.fixed('arm', 'hand', at(0.0, 0.0, QUARTER))
    assert robot.lookup('map', 'hand', 0).motion.rotation == pytest.approx((0.0, 0.0, 1.0, 0.0))
    back = robot.lookup('arm', 'odom', 0).motion.rotation
    assert back == pytest.approx((0.0, 0.0, -sin(pi / 4), cos(pi / 4)))


def test_between_two_times_motion_is_interpolated() -> None:
    tree = Tree()
    tree.moving('map', 'base', 1.0, at(0.0))
    tree.moving('map', 'base', 2.0, at(4.0, 0.0, QUARTER))
    found = tree.lookup('map', 'base', int(1.25 * SECOND))
    assert found.motion.translation == pytest.approx((1.0, 0.0, 0.0))
    assert found.motion.rotation == pytest.approx((0.0, 0.0, sin(pi / 16), cos(pi / 16)))
    assert found.time == int(1.25 * SECOND)


def test_data_may_come_in_any_order() -> None:
    tree = Tree()
    for second in (3, 1, 2):
        tree.moving('map', 'base', second, at(float(second)))
    assert [tree.origin('map', 'base', t)[0] for t in (1.0, 1.5, 2.0, 2.75, 3.0)] == [
        1.0,
        1.5,
        2.0,
        2.75,
        3.0,
    ]


def test_time_0_is_the_newest_that_all_links_know() -> None:
    tree = Tree()
    for second in (1, 2, 3):
        tree.moving('map', 'base', second, at(float(second)))
    tree.moving('base', 'arm', 2.0, at(0.0, 2.0))
    tree.moving('base', 'arm', 2.5, at(0.0, 3.0))
    tree.fixed('arm', 'hand', at(0.0))
    assert tree.lookup('map', 'base', 0) == (at(3.0), 3 * SECOND)
    for target, source in (('map', 'hand'), ('hand', 'map')):
        assert tree.lookup(target, source, 0).time == int(2.5 * SECOND)
    assert tree.origin('map', 'hand') == pytest.approx((2.5, 3.0, 0.0))
    assert tree.latest_common_time('map', 'hand', 'test') == int(2.5 * SECOND)
    assert tree.latest_common_time('hand', 'arm', 'test') == 0


def test_links_above_the_meeting_point_do_not_matter() -> None:
    tree = Tree()
    tree.moving('map', 'base', 1.0, at(0.0))
    tree.fixed('base', 'left', at(0.0, 1.0))
    tree.fixed('base', 'right', at(0.0, -1.0))
    assert tree.origin('left', 'right', 99.0) == (0.0, -2.0, 0.0)


def test_a_static_transform_holds_at_all_times_and_is_replaced_by_the_next() -> None:
    tree = Tree()
    tree.fixed('map', 'base', at(1.0), stamp=5 * SECOND)
    assert tree.origin('map', 'base', 1.0) == tree.origin('map', 'base', 1e6) == (1.0, 0.0, 0.0)
    tree.fixed('map', 'base', at(2.0))
    assert tree.origin('map', 'base', 1.0) == (2.0, 0.0, 0.0)


def test_a_moving_transform_takes_the_place_of_a_static_one() -> None:
    tree = Tree()
    tree.fixed('map', 'base', at(1.0))
    tree.moving('map', 'base', 1.0, at(2.0))
    assert tree.origin('map', 'base', 1.0) == (2.0, 0.0, 0.0)
    with pytest.raises(ExtrapolationException):
        tree.origin('map', 'base', 2.0)


def test_a_frame_may_change_its_parent() -> None:
    tree = Tree()
    tree.fixed('map', 'table', at(5.0))
    tree.moving('map', 'cup', 1.0, at(1.0))
    tree.moving('table', 'cup', 2.0, at(0.0, 1.0))
    assert tree.origin('map', 'cup', 2.0) == (5.0, 1.0, 0.0)
    assert tree.origin('map', 'cup', 1.5) == (1.0, 0.0, 0.0)  # nothing between two parents


def test_a_full_lookup_travels_in_time_with_the_fixed_frame_standing_still() -> None:
    tree = Tree()
    for second in (1, 2):
        tree.moving('map', 'base', second, at(10.0 * second))
    found = tree.lookup_full('base', 2 * SECOND, 'base', 1 * SECOND, 'map')
    assert found.motion.translation == pytest.approx((-10.0, 0.0, 0.0))
    assert found.time == 2 * SECOND


@pytest.mark.parametrize(
    ('time', 'text'),
    [
        (0.5, 'the past.  Requested time 0.500000 but the earliest data is at time 1.000000'),
        (3.0, 'the future.  Requested time 3.000000 but the latest data is at time 2.000000'),
    ],
)
def test_outside_of_what_is_known_nothing_is_invented(time: float, text: str) -> None:
    tree = Tree()
    tree.moving('map', 'base', 1.0, at(0.0))
    tree.moving('map', 'base', 2.0, at(0.0))
    with pytest.raises(ExtrapolationException) as caught:
        tree.origin('map', 'base', time)
    way = ', when looking up transform from frame [base] to frame [map]'
    assert str(caught.value) == f'Lookup would require extrapolation into {text}{way}'
    with pytest.raises(ExtrapolationException, match=r'\[map\] to frame \[base\]'):
        tree.origin('base', 'map', time)


def test_one_transform_alone_holds_at_its_own_time() -> None:
    tree = Tree()
    tree.moving('map', 'base', 1.0, at(0.0))
    assert tree.origin('map', 'base', 1.0) == (0.0, 0.0, 0.0)
    with pytest.raises(
        ExtrapolationException, match=r'at time 1\.5\d*, but only time 1\.0\d* is in the buffer'
    ):
        tree.origin('map', 'base', 1.5)


def test_old_data_goes() -> None:
    tree = Tree()
    for second in range(1, 21):
        tree.moving('map', 'base', second, at(float(second)))
    (frame,) = tree.frames()
    assert (frame.number, frame.oldest, frame.newest) == (11, 10 * SECOND, 20 * SECOND)
    with pytest.raises(
        RejectedTransform, match='TF_OLD_DATA ignoring data from the past for frame base at time 9'
    ):
        tree.moving('map', 'base', 9.0, at(0.0))


def test_the_same_data_again_changes_nothing() -> None:
    tree = Tree()
    for _ in range(3):
        tree.moving('map', 'base', 1.0, at(1.0))
    assert tree.frames()[0].number == 1
    tree.moving('map', 'base', 1.0, at(2.0))
    assert tree.origin('map', 'base', 1.0) == (2.0, 0.0, 0.0)


def test_two_trees_are_not_connected() -> None:
    tree = Tree()
    tree.fixed('map', 'base', at(0.0))
    tree.fixed('other_map', 'other_base', at(0.0))
    for time in (0.0, 1.0):
        with pytest.raises(ConnectivityException, match="connection between 'base' and 'other_base'"):
            tree.origin('base', 'other_base', time)


def test_a_loop_is_found() -> None:
    tree = Tree()
    tree.fixed('a', 'b', at(0.0))
    tree.fixed('b', 'a', at(0.0))
    tree.fixed('x', 'y', at(0.0))
    for time in (0.0, 1.0):
        with pytest.raises(LookupException, match='contains a loop'):
            tree.origin('x', 'b', time)


@pytest.mark.parametrize(
    ('target', 'error', 'text'),
    [
        ('nope', LookupException, '"nope" passed to {} does not exist. '),
        (
            '',
            InvalidArgumentException,
            'Invalid argument "" passed to {} - in tf2 frame_ids cannot be empty',
        ),
        (
            '/map',
            InvalidArgumentException,
            'Invalid argument "/map" passed to {} - in tf2 frame_ids cannot start with a \'/\'',
        ),
    ],
)
def test_a_frame_that_is_not_known_is_named(
    robot: Tree, target: str, error: type[TransformException], text: str
) -> None:
    with pytest.raises(error) as caught:
        robot.origin(target, 'base')
    assert str(caught.value) == text.format('lookupTransform argument target_frame')
    with pytest.raises(error, match='argument fixed_frame'):
        robot.lookup_full('map', 0, 'base', 0, target)


@pytest.mark.parametrize(
    ('parent', 'child', 'motion', 'reason'),
    [
        ('a', 'a', IDENTITY, 'TF_SELF_TRANSFORM'),
        ('a', '/a', IDENTITY, 'TF_SELF_TRANSFORM'),
        ('a', '', IDENTITY, 'TF_NO_CHILD_FRAME_ID'),
        ('/', 'a', IDENTITY, 'TF_NO_FRAME_ID'),
        ('a', 'b', at(nan), 'TF_NAN_INPUT'),
        ('a', 'b', at(0.0, 0.0, (0.0, 0.0, 0.0, 0.0)), 'TF_DENORMALIZED_QUATERNION'),
        ('a', 'b', at(0.0, 0.0, (0.0, 0.0, 0.0, 1.01)), 'TF_DENORMALIZED_QUATERNION'),
    ],
)
def test_a_bad_transform_is_refused(parent: str, child: str, motion: Rigid, reason: str) -> None:
    tree = Tree()
    with pytest.raises(RejectedTransform, match=reason):
        tree.fixed(parent, child, motion)
    assert tree.names() == []


def test_a_quaternion_that_is_nearly_one_is_made_one() -> None:
    tree = Tree()
    tree.fixed('/a', '/b', at(1.0, 0.0, (0.0, 0.0, 0.0, 1.004)))
    assert tree.lookup('a', 'b', 0).motion == at(1.0)
    tree.fixed('b', 'c', at(0.0, 0.0, (0.0, 0.0, 1.004, 0.0)))
    tree.fixed('c', 'd', at(5.0))
    assert tree.origin('b', 'd') == pytest.approx((-5.0, 0.0, 0.0))


def test_a_cleared_tree_knows_frames_but_no_way(robot: Tree) -> None:
    robot.clear()
    assert robot.frames() == []
    assert 'base' in robot.names()
    with pytest.raises(ConnectivityException):
        robot.origin('map', 'base')

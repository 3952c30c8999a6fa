"""The buffer of transforms in terms of messages."""

from __future__ import annotations

from math import nan

import pytest
import yaml
from builtin_interfaces.msg import Time as TimeMessage
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from rclpy.duration import Duration
from rclpy.time import Time
from std_msgs.msg import Header
from tf2_py import BufferCore, ExtrapolationException, LookupException, TransformException

HALF_TURN = Quaternion(x=0.0, y=0.0, z=1.0, w=0.0)


def transform(
    parent: str, child: str, x: float, seconds: int = 0, rotation: Quaternion | None = None
) -> TransformStamped:
    return TransformStamped(
        header=Header(frame_id=parent, stamp=TimeMessage(sec=seconds)),
        child_frame_id=child,
        transform=Transform(translation=Vector3(x=x), rotation=rotation or Quaternion()),
    )


@pytest.fixture
def core() -> BufferCore:
    """map -> base, moving, at 1 and 2 s; base -> arm, static, turned by half."""
    core = BufferCore()
    core.set_transform(transform('map', 'base', 1.0, seconds=1), 'wheels')
    core.set_transform(transform('map', 'base', 3.0, seconds=2), 'wheels')
    core.set_transform_static(transform('base', 'arm', 0.5, rotation=HALF_TURN), 'urdf')
    return core


def test_a_lookup_is_a_stamped_transform(core: BufferCore) -> None:
    assert core.lookup_transform_core('map', 'arm', Time(seconds=1)) == TransformStamped(
        header=Header(frame_id='map', stamp=TimeMessage(sec=1)),
        child_frame_id='arm',
        transform=Transform(translation=Vector3(x=1.5), rotation=HALF_TURN),
    )


@pytest.mark.parametrize('time', [Time(nanoseconds=1_250_000_000), TimeMessage(sec=1, nanosec=250_000_000)])
def test_times_are_those_of_rclpy_or_of_messages(core: BufferCore, time: Time | TimeMessage) -> None:
    found = core.lookup_transform_core('map', 'base', time)
    assert found.transform.translation.x == 1.5
    assert found.header.stamp == TimeMessage(sec=1, nanosec=250_000_000)


def test_what_is_no_time_is_a_type_error(core: BufferCore) -> None:
    with pytest.raises(TypeError, match=r'time must have sec and nanosec, or nanoseconds, not be 1\.0'):
        core.lookup_transform_core('map', 'base', 1.0)  # type: ignore[arg-type]


def test_a_check_tells_why_not(core: BufferCore) -> None:
    assert core.can_transform_core('map', 'arm', Time()) == (True, '')
    possible, reason = core.can_transform_core('map', 'arm', Time(seconds=9))
    assert not possible
    assert reason.startswith('Lookup would require extrapolation into the future.')
    assert 'canTransform argument source_frame' in core.can_transform_core('map', 'nope', Time())[1]
    times = Time(seconds=1), Time(seconds=2)
    assert core.can_transform_full_core('base', times[0], 'arm', times[1], 'map') == (True, '')
    assert core.can_transform_full_core('base', times[0], 'arm', Time(seconds=9), 'map')[0] is False


def test_a_full_lookup_travels_in_time(core: BufferCore) -> None:
    found = core.lookup_transform_full_core('base', Time(seconds=2), 'base', Time(seconds=1), 'map')
    assert found.transform.translation.x == -2.0
    assert (found.header.frame_id, found.child_frame_id, found.header.stamp.sec) == ('base', 'base', 2)


def test_the_cache_is_as_long_as_it_is_told() -> None:
    core = BufferCore(Duration(seconds=1))
    for second in (1, 2, 3):
        core.set_transform(transform('map', 'base', float(second), seconds=second), 'me')
    assert core.lookup_transform_core('map', 'base', Time(seconds=2)).transform.translation.x == 2.0
    with pytest.raises(ExtrapolationException):
        core.lookup_transform_core('map', 'base', Time(seconds=1))


def test_the_latest_common_time_is_a_time(core: BufferCore) -> None:
    assert core.get_latest_common_time('map', 'arm').nanoseconds == 2_000_000_000
    with pytest.raises(LookupException, match='"nope" passed to get_latest_common_time does not exist'):
        core.get_latest_common_time('map', 'nope')


def test_frames_are_listed_as_yaml_and_as_text(core: BufferCore) -> None:
    assert yaml.safe_load(core.all_frames_as_yaml()) == {
        'base': {
            'parent': 'map',
            'broadcaster': 'wheels',
            'rate': 2.0,
            'most_recent_transform': 2.0,
            'oldest_transform': 1.0,
            'buffer_length': 1.0,
        },
        'arm': {
            'parent': 'base',
            'broadcaster': 'urdf',
            'rate': 10000.0,
            'most_recent_transform': 0.0,
            'oldest_transform': 0.0,
            'buffer_length': 0.0,
        },
    }
    assert core.all_frames_as_string().splitlines() == [
        'Frame base exists with parent map.',
        'Frame arm exists with parent base.',
    ]
    assert BufferCore().all_frames_as_yaml() == '[]'


def test_what_cannot_be_stored_is_logged_and_ignored(
    core: BufferCore, capfd: pytest.CaptureFixture[str]
) -> None:
    core.set_transform(transform('map', 'base', nan, seconds=3), 'wheels')
    assert (
        'TF_NAN_INPUT: Ignoring transform for child_frame_id "base" from authority "wheels"'
        in capfd.readouterr().err
    )
    assert core.get_latest_common_time('map', 'base').nanoseconds == 2_000_000_000


def test_a_cleared_buffer_finds_nothing(core: BufferCore) -> None:
    core.clear()
    with pytest.raises(TransformException):
        core.lookup_transform_core('map', 'arm', Time())

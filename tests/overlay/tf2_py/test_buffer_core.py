"""The buffer of transforms in terms of messages."""

from __future__ import annotations

from math import cos, nan, pi, sin

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


def quarter(turns: float) -> Quaternion:
    """A turn about z, in quarters."""
    return Quaternion(z=sin(turns * pi / 4), w=cos(turns * pi / 4))


@pytest.fixture
def wheel() -> BufferCore:
    """map -> hub, at 2 m/s along y and a quarter turn a second; hub -> rim, 1 m along the hub's x."""
    core = BufferCore()
    for second in range(1, 5):
        moved = transform('map', 'hub', 0.0, seconds=second, rotation=quarter(second))
        moved.transform.translation.y = 2.0 * second
        core.set_transform(moved, 'motor')
    core.set_transform_static(transform('hub', 'rim', 1.0), 'urdf')
    return core


@pytest.mark.parametrize('time', [Time(seconds=2), Time(seconds=9), Time()])
def test_a_velocity_is_told_in_the_axes_of_the_observer(wheel: BufferCore, time: Time) -> None:
    linear, angular = wheel.lookupVelocityCore('hub', 'map', time, Duration(seconds=1))
    assert linear == pytest.approx((0, 2, 0))
    assert angular == pytest.approx((0, 0, pi / 2))


def test_what_turns_along_moves_faster(wheel: BufferCore) -> None:
    # From 1.75 s to 2.25 s the rim goes from angle 157.5 to 202.5 degrees around the hub.
    linear, angular = wheel.lookupVelocityCore('rim', 'map', Time(seconds=2), Duration(seconds=0.5))
    assert linear == pytest.approx((0, 2 - 2 * sin(pi / 8) / 0.5, 0), abs=1e-9)
    assert angular == pytest.approx((0, 0, pi / 2))


def test_a_velocity_may_be_that_of_any_point_and_in_any_axes(wheel: BufferCore) -> None:
    at, span = Time(seconds=2), Duration(seconds=0.5)
    rim = wheel.lookupVelocityCore('rim', 'map', at, span)
    full = wheel.lookupVelocityFullCore
    assert full('hub', 'map', 'map', (1.0, 0.0, 0.0), 'hub', at, span).linear == pytest.approx(rim.linear)
    assert full('hub', 'map', 'map', (0.0, 0.0, 0.0), 'rim', at, span).linear == pytest.approx(rim.linear)
    (x, y, z), angular = full('hub', 'map', 'hub', (0.0, 0.0, 0.0), 'hub', at, span)
    turned = 2.25 * pi / 2  # the hub's axes at the end of the interval
    assert (x, y, z) == pytest.approx((2 * sin(turned), 2 * cos(turned), 0))
    assert angular == pytest.approx((0, 0, pi / 2))


def test_what_is_fixed_stands_still(wheel: BufferCore) -> None:
    still = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    for tracked in ('rim', 'hub'):
        assert wheel.lookupVelocityCore(tracked, 'hub', Time(), Duration(seconds=1)) == still


def test_a_velocity_needs_an_interval_and_known_frames(wheel: BufferCore) -> None:
    with pytest.raises(ValueError, match='an interval above 0'):
        wheel.lookupVelocityCore('hub', 'map', Time(), Duration())
    with pytest.raises(LookupException, match='"nope" passed to lookupVelocity'):
        wheel.lookupVelocityCore('nope', 'map', Time(), Duration(seconds=1))
    with pytest.raises(ExtrapolationException, match='into the past'):
        wheel.lookupVelocityCore('hub', 'map', Time(), Duration(seconds=30))


def test_the_cache_is_as_long_as_it_is_told() -> None:
    core = BufferCore(Duration(seconds=1))
    for second in (1, 2, 3):
        core.set_transform(transform('map', 'base', float(second), seconds=second), 'me')
    assert core.lookup_transform_core('map', 'base', Time(seconds=2)).transform.translation.x == 2.0
    with pytest.raises(ExtrapolationException):
        core.lookup_transform_core('map', 'base', Time(seconds=1))


def test_the_latest_common_time_is_a_time_of_the_system_clock_as_in_tf2(core: BufferCore) -> None:
    assert core.get_latest_common_time('map', 'arm') == Time(nanoseconds=2_000_000_000)
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

"""Filters that hand messages on, and the cache."""

from __future__ import annotations

import pytest
from builtin_interfaces.msg import Time as Stamp
from helpers.collector import Collector
from helpers.spinning import MakeNode, Spin, wait_until
from message_filters import ApproximateTimeSynchronizer, Cache, SimpleFilter, Subscriber
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from sensor_msgs.msg import Image, Imu
from std_msgs.msg import Header, String


def at(seconds: int) -> Time:
    return Time(seconds=seconds, clock_type=ClockType.ROS_TIME)


def image(seconds: int) -> Image:
    return Image(header=Header(stamp=Stamp(sec=seconds)))


def seconds_of(images: list[Image]) -> list[int]:
    return [image.header.stamp.sec for image in images]


def test_callbacks_are_called_in_order_with_their_arguments() -> None:
    source, came = SimpleFilter(), list[tuple[object, ...]]()
    source.registerCallback(lambda *args: came.append(('first', *args)), 1, 2)
    source.registerCallback(lambda *args: came.append(('second', *args)))
    source.signalMessage('message')
    assert came == [('first', 'message', 1, 2), ('second', 'message')]


def test_a_callback_is_taken_back_by_its_connection() -> None:
    source, came = SimpleFilter(), list[str]()
    first = source.registerCallback(came.append)
    del source.callbacks[first]
    second = source.registerCallback(lambda message: came.append(message.upper()))
    source.registerCallback(came.append)
    source.signalMessage('m')
    assert came == ['M', 'm']
    assert second != first


@pytest.fixture
def cache() -> Cache:
    """A cache of three, given four images of 1 to 4 s."""
    source = SimpleFilter()
    cache = Cache(source, 3)
    for second in (1, 2, 3, 4):
        source.signalMessage(image(second))
    return cache


def test_a_cache_keeps_the_last_messages(cache: Cache) -> None:
    assert seconds_of(cache.getInterval(at(0), at(9))) == [2, 3, 4]
    assert (cache.getOldestTime(), cache.getLastestTime(), cache.getLatestTime()) == (at(2), at(4), at(4))
    assert seconds_of([cache.getLast()]) == [4]
    assert (seconds_of(cache.cache_msgs), cache.cache_times) == ([2, 3, 4], [at(2), at(3), at(4)])


def test_a_cache_finds_messages_by_time(cache: Cache) -> None:
    assert seconds_of(cache.getInterval(at(2), at(3))) == [2, 3]
    assert seconds_of([cache.getElemAfterTime(at(3)), cache.getElemBeforeTime(at(3))]) == [3, 3]
    assert cache.getElemAfterTime(at(5)) is None
    assert cache.getElemBeforeTime(at(1)) is None
    with pytest.raises(AssertionError, match='reversed'):
        cache.getInterval(at(3), at(2))


def test_an_empty_cache_knows_nothing() -> None:
    cache = Cache(SimpleFilter())
    assert [cache.getLast(), cache.getLastestTime(), cache.getOldestTime()] == [None, None, None]


def test_a_cache_passes_messages_on() -> None:
    source, came = SimpleFilter(), list[Image]()
    Cache(source, 1).registerCallback(came.append)
    source.signalMessage(image(1))
    source.signalMessage(image(2))
    assert seconds_of(came) == [1, 2]


def test_a_cache_drops_headerless_messages_unless_allowed() -> None:
    source = SimpleFilter()
    strict, lenient = Cache(source), Cache(source, allow_headerless=True)
    source.signalMessage(String(data='x'))
    assert strict.getLast() is None
    assert lenient.getLast() == String(data='x')


def test_two_topics_are_synchronized(context: Context, make_node: MakeNode, spin: Spin) -> None:
    node, came = make_node(), Collector[tuple[int, int]]()
    cameras = node.create_publisher(Image, 'camera', 10)
    imus = node.create_publisher(Imu, 'imu', 10)
    subscribers = [Subscriber(node, Image, 'camera'), Subscriber(node, Imu, 'imu')]
    synchronizer = ApproximateTimeSynchronizer(subscribers, 10, slop=0.5)
    synchronizer.registerCallback(lambda camera, imu: came((camera.header.stamp.sec, imu.header.stamp.sec)))
    wait_until(context, lambda: cameras.get_subscription_count() == 1 and imus.get_subscription_count() == 1)
    spin(node)
    for second in (1, 2, 3):
        cameras.publish(image(second))
    for second in (2, 3, 9):
        imus.publish(Imu(header=Header(stamp=Stamp(sec=second))))
    assert sorted(came.expect(2)) == [(2, 2), (3, 3)]


def test_a_subscriber_has_its_subscriptions_attributes(make_node: MakeNode) -> None:
    profile = QoSProfile(depth=3, reliability=ReliabilityPolicy.BEST_EFFORT)
    subscriber = Subscriber(make_node(), Image, 'camera', qos_profile=profile)
    assert subscriber.getTopic() == 'camera'
    assert subscriber.topic_name == '/camera'
    assert subscriber.sub.qos_profile == profile
    with pytest.raises(AttributeError, match='nonsense'):
        _ = subscriber.nonsense

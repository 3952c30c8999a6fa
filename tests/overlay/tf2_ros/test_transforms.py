"""Transforms sent, received and waited for by nodes."""

from __future__ import annotations

import gc
import threading
import time
from collections.abc import Iterator
from weakref import ref

import pytest
import rclpy
import yaml
from builtin_interfaces.msg import Time as TimeMessage
from geometry_msgs.msg import Transform, TransformStamped, Vector3
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, result_of, wait_until
from rclpy.clock import ROSClock
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.time import Time
from std_msgs.msg import Header
from tf2_msgs.srv import FrameGraph
from tf2_py.buffer_core import Instant
from tf2_ros import (
    Buffer,
    BufferInterface,
    LookupException,
    NotImplementedException,
    StaticTransformBroadcaster,
    TransformBroadcaster,
    TransformException,
    TransformListener,
)

LATEST = Time()
LONG_ENOUGH = Duration(seconds=PATIENCE)


def transform(child: str, x: float, seconds: int = 1, parent: str = 'map') -> TransformStamped:
    return TransformStamped(
        header=Header(frame_id=parent, stamp=TimeMessage(sec=seconds)),
        child_frame_id=child,
        transform=Transform(translation=Vector3(x=x)),
    )


def x_of(found: TransformStamped) -> float:
    x: float = found.transform.translation.x
    return x


class AskedBuffer(Buffer):
    """A buffer that tells when somebody has asked it in vain, and so begins to wait."""

    def __init__(self, node: Node | None = None) -> None:
        super().__init__(node=node)
        self.asked = threading.Event()

    def lookup_transform_core(self, target_frame: str, source_frame: str, time: Instant) -> TransformStamped:
        try:
            return super().lookup_transform_core(target_frame, source_frame, time)
        finally:
            self.asked.set()


@pytest.fixture
def node(make_node: MakeNode) -> Node:
    return make_node()


@pytest.fixture
def buffer(node: Node) -> Buffer:
    return Buffer(node=node)


@pytest.fixture
def listener(buffer: Buffer, node: Node) -> Iterator[TransformListener]:
    listener = TransformListener(buffer, node)
    yield listener
    listener.unregister()


def connect(broadcaster: TransformBroadcaster | StaticTransformBroadcaster, context: Context) -> None:
    wait_until(context, lambda: broadcaster.pub_tf.get_subscription_count() > 0)


@pytest.mark.usefixtures('listener')
def test_what_is_broadcast_can_be_looked_up(
    context: Context, node: Node, buffer: Buffer, make_node: MakeNode, spin: Spin
) -> None:
    broadcaster = TransformBroadcaster(make_node('robot'))
    connect(broadcaster, context)
    spin(node)
    broadcaster.sendTransform(transform('base', 1.0, 1))
    broadcaster.sendTransform([transform('base', 3.0, 2), transform('arm', 0.5, 2, parent='base')])
    assert x_of(buffer.lookup_transform('map', 'arm', LATEST, LONG_ENOUGH)) == 3.5
    assert x_of(buffer.lookup_transform('map', 'base', Time(nanoseconds=1_500_000_000))) == 2.0


def test_static_transforms_reach_those_who_come_later_all_of_them(make_node: MakeNode, spin: Spin) -> None:
    broadcaster = StaticTransformBroadcaster(make_node('robot'))
    broadcaster.sendTransform(transform('lidar', 1.0, parent='base'))
    broadcaster.sendTransform((transform('camera', 2.0, parent='base'),))
    broadcaster.sendTransform(transform('lidar', 3.0, parent='base'))
    late = make_node('late')
    buffer = Buffer()
    TransformListener(buffer, late, static_only=True)  # lives as long as its node
    spin(late)
    assert x_of(buffer.lookup_transform('base', 'camera', LATEST, LONG_ENOUGH)) == 2.0
    assert x_of(buffer.lookup_transform('base', 'lidar', Time(seconds=77))) == 3.0


@pytest.mark.usefixtures('isolated')
def test_a_waiting_lookup_is_woken_by_the_transform_that_completes_it() -> None:
    buffer = AskedBuffer()

    def tell() -> None:
        buffer.asked.wait(PATIENCE)
        buffer.set_transform(transform('base', 1.0), 'test')
        buffer.set_transform_static(transform('arm', 2.0, parent='base'), 'test')

    teller = threading.Thread(target=tell)
    teller.start()
    assert buffer.can_transform('map', 'arm', LATEST, LONG_ENOUGH) is True
    assert x_of(buffer.lookup_transform('map', 'arm', LATEST, LONG_ENOUGH)) == 3.0
    teller.join()


@pytest.mark.usefixtures('isolated')
def test_what_does_not_come_in_time_is_told_as_the_reason_why_not() -> None:
    buffer, start = Buffer(), time.monotonic()
    with pytest.raises(LookupException, match='"map" passed to lookupTransform argument target_frame'):
        buffer.lookup_transform('map', 'base', LATEST, Duration(seconds=0.05))
    assert 0.04 < time.monotonic() - start < 5
    possible, reason = buffer.can_transform(  # type: ignore[misc]
        'map', 'base', LATEST, Duration(seconds=0.01), return_debug_tuple=True
    )
    assert not possible
    assert 'does not exist' in reason
    with pytest.raises(TransformException):
        buffer.lookup_transform_full('map', LATEST, 'base', LATEST, 'odom', Duration(seconds=0.01))
    assert not buffer.can_transform_full('map', LATEST, 'base', LATEST, 'odom')


def test_shutdown_ends_a_wait(context: Context, node: Node) -> None:
    buffer, ended = AskedBuffer(node), threading.Event()

    def wait() -> None:
        with pytest.raises(LookupException):
            buffer.lookup_transform('map', 'base', LATEST, LONG_ENOUGH)
        ended.set()

    waiter = threading.Thread(target=wait)
    waiter.start()
    assert buffer.asked.wait(PATIENCE)
    context.try_shutdown()
    assert ended.wait(PATIENCE)
    waiter.join()


@pytest.mark.usefixtures('isolated')
def test_a_future_is_done_when_the_transform_is_there() -> None:
    buffer = Buffer()
    future = buffer.wait_for_transform_async('map', 'base', LATEST)
    assert not future.done()
    buffer.set_transform(transform('base', 1.0), 'test')
    assert x_of(result_of(future)) == 1.0
    assert x_of(result_of(buffer.wait_for_transform_async('map', 'base', LATEST))) == 1.0
    full = buffer.wait_for_transform_full_async('map', LATEST, 'base', Time(seconds=2), 'map')
    buffer.set_transform(transform('base', 2.0, seconds=3), 'test')
    assert x_of(result_of(full)) == 1.5


@pytest.mark.usefixtures('isolated')
def test_a_future_that_nobody_wants_any_more_is_forgotten() -> None:
    buffer = Buffer()
    future = buffer.wait_for_transform_async('map', 'base', LATEST)
    future.cancel()
    reference = ref(future)
    del future
    gc.collect()
    assert reference() is None


@pytest.mark.usefixtures('listener')
def test_a_coroutine_callback_awaits_a_transform(
    context: Context, node: Node, buffer: Buffer, executor: Executor
) -> None:
    broadcaster = TransformBroadcaster(node)
    connect(broadcaster, context)

    async def callback() -> float:
        broadcaster.sendTransform(transform('base', 4.0))
        return x_of(await buffer.lookup_transform_async('map', 'base', LATEST))

    executor.add_node(node)
    task = executor.create_task(callback)
    executor.spin_until_future_complete(task, 10)
    assert task.result() == 4.0


def test_a_listener_with_its_own_thread_needs_no_spinning(context: Context, node: Node) -> None:
    buffer, sender = Buffer(), TransformBroadcaster(node)
    listener = TransformListener(buffer, node, spin_thread=True)
    connect(sender, context)
    sender.sendTransform(transform('base', 1.0))
    assert x_of(buffer.lookup_transform('map', 'base', LATEST, LONG_ENOUGH)) == 1.0
    listener.unregister()
    assert not listener.dedicated_listener_thread.is_alive()
    wait_until(context, lambda: sender.pub_tf.get_subscription_count() == 0)


def test_a_listeners_thread_listens_while_another_executor_has_the_node_and_its_thread_waits(
    context: Context, node: Node
) -> None:
    buffer = Buffer(node=node)
    listener = TransformListener(buffer, node, spin_thread=True)
    broadcaster = TransformBroadcaster(node)
    connect(broadcaster, context)

    def callback() -> float:
        broadcaster.sendTransform(transform('base', 4.0))
        return x_of(result_of(buffer.wait_for_transform_async('map', 'base', LATEST)))  # keeps the thread

    with SingleThreadedExecutor(context=context) as executor:
        executor.add_node(node)
        task = executor.create_task(callback)
        executor.spin_until_future_complete(task, 10)
        assert task.result() == 4.0
        assert node.executor is executor
    listener.unregister()


def test_a_listeners_thread_takes_no_node_from_its_executor(context: Context, node: Node) -> None:
    with SingleThreadedExecutor(context=context) as executor:
        executor.add_node(node)
        listener = TransformListener(Buffer(node=node), node, spin_thread=True)
        assert node.executor is executor
        listener.unregister()


@pytest.mark.usefixtures('isolated')
def test_a_listener_without_a_node_makes_one_that_hears_transforms_and_nothing_else() -> None:
    with rclpy.init(args=['--ros-args', '-p', 'use_sim_time:=true']):
        buffer = Buffer()
        listener = TransformListener(buffer, None, spin_thread=True)
        topics = [subscription.topic_name for subscription in listener.node.subscriptions]
        assert topics == ['/tf', '/tf_static']  # and no /clock
        sender = StaticTransformBroadcaster(Node('sender'))
        sender.sendTransform(transform('base', 1.0))
        assert x_of(buffer.lookup_transform('map', 'base', LATEST, LONG_ENOUGH)) == 1.0
        listener.unregister()


def test_the_frames_are_a_service(node: Node, buffer: Buffer, make_node: MakeNode, spin: Spin) -> None:
    buffer.set_transform(transform('base', 1.0), 'me')
    client = make_node('asker').create_client(FrameGraph, 'tf2_frames')
    assert client.wait_for_service(10)
    spin(node)
    response = client.call(FrameGraph.Request(), 10)
    assert response is not None
    assert yaml.safe_load(response.frame_yaml)['base']['parent'] == 'map'


def test_a_jump_back_in_time_empties_the_buffer(node: Node, buffer: Buffer) -> None:
    clock = node.get_clock()
    assert isinstance(clock, ROSClock)
    clock.set_ros_time_override(Time(seconds=100))
    clock._set_ros_time_is_active(True)
    buffer.set_transform(transform('base', 1.0), 'test')
    clock.set_ros_time_override(Time(seconds=101))
    assert buffer.can_transform('map', 'base', LATEST)
    clock.set_ros_time_override(Time(seconds=3))
    assert not buffer.can_transform('map', 'base', LATEST)


def test_a_timeout_is_a_time_of_the_buffers_clock(node: Node) -> None:
    buffer, failed = AskedBuffer(node), Collector[TransformException]()
    clock = node.get_clock()
    assert isinstance(clock, ROSClock)
    clock._set_ros_time_is_active(True)

    def ask() -> None:
        try:
            buffer.lookup_transform('map', 'base', LATEST, Duration(seconds=100))
        except TransformException as error:
            failed(error)

    thread = threading.Thread(target=ask)
    thread.start()
    assert buffer.asked.wait(PATIENCE)
    clock.set_ros_time_override(Time(seconds=99))
    assert failed.items == []
    clock.set_ros_time_override(Time(seconds=200))
    assert isinstance(failed.expect()[0], LookupException)
    thread.join()


def test_a_custom_source_must_say_how_to_look_up() -> None:
    with pytest.raises(NotImplementedException, match='not implemented'):
        BufferInterface().can_transform('a', 'b', LATEST)


def test_a_callback_waits_while_another_thread_listens(
    context: Context, node: Node, buffer: Buffer, listener: TransformListener, spin: Spin
) -> None:
    broadcaster, came = TransformBroadcaster(node), Collector[float]()
    connect(broadcaster, context)

    def callback() -> None:
        broadcaster.sendTransform(transform('base', 4.0))
        came(x_of(buffer.lookup_transform('map', 'base', LATEST, LONG_ENOUGH)))

    guard = node.create_guard_condition(callback)
    spin(node, threads=2)
    guard.trigger()
    assert came.expect() == [4.0]


def test_a_callback_of_the_only_thread_waits_for_what_its_own_listener_hears(
    context: Context, node: Node, buffer: Buffer, listener: TransformListener, make_node: MakeNode
) -> None:
    broadcaster, asked = TransformBroadcaster(make_node('robot')), threading.Event()
    connect(broadcaster, context)
    lookup = buffer.lookup_transform_core

    def asking(target_frame: str, source_frame: str, time: Instant) -> TransformStamped:
        try:
            return lookup(target_frame, source_frame, time)
        finally:
            asked.set()

    buffer.lookup_transform_core = asking  # type: ignore[method-assign]

    def send() -> None:
        assert asked.wait(PATIENCE)
        broadcaster.sendTransform(transform('base', 4.0))
        broadcaster.sendTransform(transform('arm', 0.5, parent='base'))

    with SingleThreadedExecutor(context=context) as executor:
        executor.add_node(node)
        sender = threading.Thread(target=send)
        sender.start()
        task = executor.create_task(lambda: x_of(buffer.lookup_transform('map', 'arm', LATEST, LONG_ENOUGH)))
        executor.spin_until_future_complete(task, 10)
        sender.join()
    assert task.result() == 4.5


def test_a_lookup_in_a_callback_of_the_only_thread_ends_by_its_timeout(
    context: Context, node: Node, buffer: Buffer, listener: TransformListener
) -> None:
    broadcaster = TransformBroadcaster(node)
    connect(broadcaster, context)

    def callback() -> str:
        broadcaster.sendTransform(transform('base', 4.0))
        with pytest.raises(LookupException, match='"arm"'):
            buffer.lookup_transform('base', 'arm', LATEST, Duration(seconds=0.1))
        return str(x_of(buffer.lookup_transform('map', 'base', LATEST)))

    with SingleThreadedExecutor(context=context) as executor:
        executor.add_node(node)
        task = executor.create_task(callback)
        executor.spin_until_future_complete(task, 10)
        assert task.result() == '4.0'

"""tf2_ros.TransformListener: fills a buffer from /tf and /tf_static."""

from __future__ import annotations

from collections.abc import Callable
from threading import Thread
from typing import Any, Self

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.subscription import Subscription
from tf2_msgs.msg import TFMessage
from tf2_py import BufferCore

from goalwire.execution.ready_queue import NodeWorkQueue
from tf2_ros.buffer import Buffer

__all__ = ['TransformListener']

DEFAULT_TF_TOPIC = '/tf'
DEFAULT_STATIC_TF_TOPIC = '/tf_static'
AUTHORITY = 'default_authority'


class TransformListener:
    """Fills a buffer by subscriptions of `node`; if `node` is None, the listener makes its own node.

    With `spin_thread` the listener has its own thread, which also spins the node until another executor does.
    With `static_only` it does not subscribe to /tf.
    """

    def __init__(
        self,
        buffer: BufferCore,
        node: Node | None,
        *,
        spin_thread: bool = False,
        qos: QoSProfile | int | None = None,
        static_qos: QoSProfile | int | None = None,
        tf_topic: str = DEFAULT_TF_TOPIC,
        tf_static_topic: str = DEFAULT_STATIC_TF_TOPIC,
        static_only: bool = False,
    ) -> None:
        self.buffer = buffer
        self._own_node = node is None
        self.node = node or Node(
            f'transform_listener_impl_{id(self):x}',
            enable_rosout=False,
            start_parameter_services=False,
            # the listener reads no clock, so its node need not subscribe to /clock
            parameter_overrides=[Parameter('use_sim_time', value=False)],
        )
        # A group of its own: a waiting callback of the default group must not block the listener.
        self.group = ReentrantCallbackGroup()
        if spin_thread:
            self._thread_home = _ThreadHome()
            self.group.work_queue = self._thread_home.work_queue
        self._subscriptions: list[Subscription[Any]] = []  # subscriptions keep the listener alive
        if not static_only:
            moving = QoSProfile(depth=100) if qos is None else qos
            self.tf_sub = self._subscribe(tf_topic, self.callback, moving)
        latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.tf_static_sub = self._subscribe(
            tf_static_topic, self.static_callback, latched if static_qos is None else static_qos
        )
        if spin_thread:
            self._start_thread()

    def unregister(self) -> None:
        """Stop listening; end the listener's thread, and destroy its own node, if it has them. Idempotent."""
        if hasattr(self, 'executor'):
            self.executor.shutdown()
            self.dedicated_listener_thread.join()
        while self._subscriptions:
            self.node.destroy_subscription(self._subscriptions.pop())
        if self._own_node:
            self.node.destroy_node()

    def callback(self, data: TFMessage) -> None:
        """Put transforms from /tf into the buffer."""
        for transform in data.transforms:
            self.buffer.set_transform(transform, AUTHORITY)

    def static_callback(self, data: TFMessage) -> None:
        """Put transforms from /tf_static into the buffer."""
        for transform in data.transforms:
            self.buffer.set_transform_static(transform, AUTHORITY)

    def _subscribe(
        self, topic: str, callback: Callable[[TFMessage], None], qos: QoSProfile | int
    ) -> Subscription[Any]:
        subscription = self.node.create_subscription(
            TFMessage, topic, callback, qos, callback_group=self.group
        )
        self._subscriptions.append(subscription)
        if isinstance(self.buffer, Buffer):
            self.buffer.hear(subscription.event_queue)
        return subscription

    def _start_thread(self) -> None:
        self.executor = SingleThreadedExecutor(context=self.node.context)
        self.executor.add_node(self._thread_home)
        if self.node.executor is None:
            self.executor.add_node(self.node)
        self.dedicated_listener_thread = Thread(
            target=_spin, args=(self.executor,), name='tf2_listener', daemon=True
        )
        self.dedicated_listener_thread.start()

    def __del__(self) -> None:
        if hasattr(self, 'tf_static_sub'):
            self.unregister()


class _ThreadHome:
    """Keeps the listener in its executor: `rclpy.spin(node)` removes the node from there, but not this
    object.
    """

    def __init__(self) -> None:
        self.work_queue = NodeWorkQueue()
        self.executor: object = None

    @property
    def handle(self) -> Self:
        """The object itself."""
        return self


def _spin(executor: SingleThreadedExecutor) -> None:
    try:
        executor.spin()
    except ExternalShutdownException:
        return

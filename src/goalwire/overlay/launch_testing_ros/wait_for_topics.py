"""launch_testing_ros.wait_for_topics: waits until a message has come on each of several topics."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from contextlib import suppress
from functools import partial
from threading import Event, Lock, Thread
from types import TracebackType
from typing import Any, Self
from uuid import uuid4

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

__all__ = ['WaitForTopics']


class WaitForTopics:
    """Waits for topics: `with WaitForTopics([('chatter', String)], timeout=5.0):` waits, then runs its block.

    Or call `wait` and `shutdown`. The object has its own node in its own context, apart from those of the
    test.
    """

    def __init__(
        self,
        topic_tuples: Iterable[tuple[str, type[Any]]],
        timeout: float = 5.0,
        messages_received_buffer_length: int = 10,
    ) -> None:
        """Open the node, but subscribe to nothing yet: `wait` does that. `timeout` is in s.

        Of each topic the latest `messages_received_buffer_length` messages are kept.
        """
        self.topic_tuples = list(topic_tuples)
        self.timeout = timeout
        self.messages_received_buffer_length = messages_received_buffer_length
        self._messages: dict[str, deque[Any]] = {}
        self._received: set[str] = set()
        self._all_received = Event()
        self._lock = Lock()  # messages come on the thread that spins
        self._context = Context()
        rclpy.init(context=self._context)
        self._node = Node(f'_test_node_{uuid4().hex[:10]}', context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = Thread(target=self._spin, name='wait_for_topics')
        self._thread.start()

    def wait(self) -> bool:
        """Wait until every topic has had a new message; False if that takes longer than `timeout`."""
        new = [(topic, cls) for topic, cls in self.topic_tuples if topic not in self._messages]
        with self._lock:
            self._all_received.clear()
            self._received.clear()
            for messages in self._messages.values():
                messages.clear()
            # Known before the first subscription: a message on one topic is not yet a message on all.
            for topic, _ in new:
                self._messages[topic] = deque(maxlen=self.messages_received_buffer_length)
        for topic, cls in new:
            self._node.create_subscription(cls, topic, partial(self._take, topic), 10)
        return self._all_received.wait(self.timeout)

    def shutdown(self) -> None:
        """Stop listening to the topics. Received messages are kept."""
        self._context.try_shutdown()
        self._thread.join()
        self._executor.shutdown()
        self._node.destroy_node()

    def topics_received(self) -> set[str]:
        """Return the topics on which a message has come."""
        return set(self._received)

    def topics_not_received(self) -> set[str]:
        """Return the topics on which no message has come."""
        return self._messages.keys() - self._received

    def received_messages(self, topic_name: str) -> list[Any]:
        """Return the latest messages of a topic; raises KeyError for a topic that is not waited for."""
        if topic_name not in self._messages:
            raise KeyError(f'No messages received for topic: {topic_name}')
        return list(self._messages[topic_name])

    def _take(self, topic: str, message: Any) -> None:
        with self._lock:
            self._messages[topic].append(message)
            self._received.add(topic)
            if self._received == self._messages.keys():
                self._all_received.set()

    def _spin(self) -> None:
        with suppress(ExternalShutdownException):
            self._executor.spin()

    def __enter__(self) -> Self:
        """Call `wait`; raises RuntimeError, naming the topics without a message, if it returns False."""
        if not self.wait():
            missing = self.topics_not_received()
            self.shutdown()
            raise RuntimeError('Did not receive messages on these topics: ', missing)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.shutdown()

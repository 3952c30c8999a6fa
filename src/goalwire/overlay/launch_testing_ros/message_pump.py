"""launch_testing_ros.message_pump: spins a node on a thread of its own."""

from __future__ import annotations

from threading import Thread

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

__all__ = ['MessagePump']

_STOP_S = 5.0


class MessagePump:
    """Spins a node in a thread of its own, from `start` until `stop`."""

    def __init__(self, node: Node, context: Context | None = None) -> None:
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(node)
        self._end = self._executor.create_future()
        self._thread = Thread(target=self._spin, name='msg_pump_thread')

    def start(self) -> None:
        """Begin to spin. May be called only once for each object."""
        self._thread.start()

    def stop(self) -> None:
        """Stop spinning, and wait for the running callback; raises Exception after 5 s."""
        self._end.set_result(None)
        self._thread.join(_STOP_S)
        if self._thread.is_alive():
            raise Exception('Timed out waiting for message pump to stop')  # noqa: TRY002 - upstream's
        self._executor.shutdown()

    def _spin(self) -> None:
        self._executor.spin_until_future_complete(self._end)

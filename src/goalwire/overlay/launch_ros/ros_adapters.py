"""launch_ros.ros_adapters: a node of rclpy that spins beside a launch, for actions that a program defines.

The actions of launch_ros itself use a node in the launch's loop instead.
"""

from __future__ import annotations

import os
import threading
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from goalwire.errors import LaunchError
from goalwire.launching.event_handlers import OnShutdown
from goalwire.launching.model import LaunchContext

__all__ = ['ROSAdapter', 'get_ros_adapter', 'get_ros_node']

_GLOBAL = 'ros_adapter'


class ROSAdapter:
    """A context, a node named `launch_ros_<pid>`, and a thread that spins it."""

    def __init__(self, *, argv: list[str] | None = None, autostart: bool = True) -> None:
        self._argv = list(argv or ())
        self._running: tuple[Context, Node, SingleThreadedExecutor, threading.Thread] | None = None
        if autostart:
            self.start()

    def start(self) -> None:
        """Open the node and spin it in a thread. Raises LaunchError if the node is open already."""
        if self._running is not None:
            raise LaunchError('this ROS adapter has been started already')
        context = rclpy.Context()
        rclpy.init(args=self._argv, context=context)
        node = rclpy.create_node(f'launch_ros_{os.getpid()}', context=context)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        thread = threading.Thread(target=executor.spin, name='launch_ros', daemon=True)
        self._running = context, node, executor, thread
        thread.start()

    def shutdown(self) -> None:
        """Close the node, and wait for its thread. Raises LaunchError if the node is not open."""
        if self._running is None:
            raise LaunchError('this ROS adapter is not running')
        context, node, executor, thread = self._running
        self._running = None
        executor.shutdown()
        thread.join()
        node.destroy_node()
        context.try_shutdown()

    @property
    def argv(self) -> list[str]:
        return self._argv

    @property
    def ros_context(self) -> Context | None:
        return None if self._running is None else self._running[0]

    @property
    def ros_node(self) -> Node | None:
        return None if self._running is None else self._running[1]

    @property
    def ros_executor(self) -> SingleThreadedExecutor | None:
        return None if self._running is None else self._running[2]


def get_ros_adapter(context: LaunchContext) -> ROSAdapter:
    """Return a launch's ROSAdapter. The first call opens the adapter, and the launch's end closes it."""
    found = context.get_globals().get(_GLOBAL)
    if isinstance(found, ROSAdapter):
        return found
    adapter = ROSAdapter()
    context.extend_globals({_GLOBAL: adapter})

    def close(*_: Any) -> None:
        context.remove_globals([_GLOBAL])
        adapter.shutdown()

    context.register_event_handler(OnShutdown(on_shutdown=close, handle_once=True))
    return adapter


def get_ros_node(context: LaunchContext) -> Any:
    """Return the node of rclpy that belongs to a launch; the first call opens the node."""
    return get_ros_adapter(context).ros_node

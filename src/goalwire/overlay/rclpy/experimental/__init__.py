"""rclpy.experimental: ROS 2's experimental classes, each of which is imported at its first use."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rclpy.experimental.async_client import AsyncClient
    from rclpy.experimental.async_clock import AsyncClock
    from rclpy.experimental.async_node import AsyncNode
    from rclpy.experimental.async_publisher import AsyncPublisher
    from rclpy.experimental.async_service import AsyncService
    from rclpy.experimental.async_subscription import AsyncSubscription
    from rclpy.experimental.async_timer import AsyncTimer
    from rclpy.experimental.events_executor import EventsExecutor

__all__ = [
    'AsyncClient',
    'AsyncClock',
    'AsyncNode',
    'AsyncPublisher',
    'AsyncService',
    'AsyncSubscription',
    'AsyncTimer',
    'EventsExecutor',
]

_ORIGINS = {
    'AsyncClient': 'async_client',
    'AsyncClock': 'async_clock',
    'AsyncNode': 'async_node',
    'AsyncPublisher': 'async_publisher',
    'AsyncService': 'async_service',
    'AsyncSubscription': 'async_subscription',
    'AsyncTimer': 'async_timer',
    'EventsExecutor': 'events_executor',
}


def __getattr__(name: str) -> object:
    origin = _ORIGINS.get(name)
    if origin is None:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    found = getattr(import_module(f'{__name__}.{origin}'), name)
    globals()[name] = found
    return found

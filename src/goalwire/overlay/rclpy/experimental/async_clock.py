"""rclpy.experimental.async_clock: a clock that coroutines sleep by."""

from goalwire.execution.asyncio.clock import AsyncClock

__all__ = ['AsyncClock']

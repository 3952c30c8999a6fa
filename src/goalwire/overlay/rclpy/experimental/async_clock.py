"""rclpy.experimental.async_clock: a clock with an awaitable `sleep`."""

from goalwire.execution.asyncio.clock import AsyncClock

__all__ = ['AsyncClock']

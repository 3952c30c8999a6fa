"""rclpy.experimental.async_clock: a clock whose `sleep` coroutines await."""

from goalwire.execution.asyncio.clock import AsyncClock

__all__ = ['AsyncClock']

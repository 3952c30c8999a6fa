"""one_off_timer and reuse_timer: demo_nodes_cpp's timers that are cancelled and started anew."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node
from rclpy.timer import Timer

from goalwire.apps.programs.running import spin


class OneOffTimer(Node):
    """A node whose 2 s timer makes a new timer at each tick; the new timer ticks once."""

    def __init__(self) -> None:
        super().__init__('one_off_timer')
        self._count = 0
        self._one_off: Timer | None = None
        self.create_timer(2.0, self._tick)

    def _tick(self) -> None:
        self.get_logger().info(
            'in periodic_timer callback' if self._count else 'in periodic_timer callback, first'
        )
        self._count += 1
        if self._one_off is not None:
            self.destroy_timer(self._one_off)
        self._one_off = self.create_timer(1.0, self._tick_once)

    def _tick_once(self) -> None:
        self.get_logger().info('in one_off_timer callback')
        if self._one_off is not None:
            self._one_off.cancel()


class ReuseTimer(Node):
    """A node whose one-off timer cancels itself when it ticks, and is restarted by a periodic timer."""

    def __init__(self) -> None:
        super().__init__('reuse_timer')
        self._count = 0
        self._one_off = self.create_timer(1.0, self._tick_once)
        self._one_off.cancel()
        self.create_timer(2.0, self._tick)

    def _tick_once(self) -> None:
        self.get_logger().info('in one_off_timer callback')
        self._one_off.cancel()

    def _tick(self) -> None:
        if self._count % 3 == 0:
            self.get_logger().info('  resetting one off timer')
            self._one_off.reset()
        else:
            self.get_logger().info('  not resetting one off timer')
        self._count += 1


def one_off(args: Sequence[str] | None = None) -> int:
    """Run one_off_timer."""
    return spin(OneOffTimer, args)


def reuse(args: Sequence[str] | None = None) -> int:
    """Run reuse_timer."""
    return spin(ReuseTimer, args)

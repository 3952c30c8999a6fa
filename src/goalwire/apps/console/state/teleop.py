"""Drives a robot by hand: it moves only while a hand holds the pad, and while that hand is heard in time.

A hand that lets go, falls silent or is heard late stops the robot. After silence or delay the pad must be let
go and held again.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from time import monotonic
from typing import Any

SILENT_S = 0.35
"""Seconds without a word after which the hand counts as lost; it speaks each 0.1 s."""
LATE_S = 0.4
"""Seconds by which a word may come later than the quickest word of the same press."""
TWIST = 'geometry_msgs/msg/Twist'
TWIST_STAMPED = 'geometry_msgs/msg/TwistStamped'


class Teleop:
    """One hand on one pad."""

    def __init__(self, send: Callable[[float, float], object], on_lost: Callable[[str], object]) -> None:
        """`send` publishes a velocity: the fractions of the full speed ahead and of the full turn left.

        Both are -1 to 1, and 0 and 0 stop the robot. `on_lost` gets the reason if the hand was lost.
        """
        self._send = send
        self._on_lost = on_lost
        self._press = 0.0
        self._drives = False
        self._least = math.inf
        self._timer: asyncio.TimerHandle | None = None

    @property
    def drives(self) -> bool:
        """True while the robot follows the hand."""
        return self._drives

    def hold(self, press: float, at: float, ahead: float, left: float) -> None:
        """Note a word of the hand: it holds the pad there.

        `press` counts the presses of the pad upwards. `at` is the time since this press began, in s by the
        browser's clock. Words of a press that has ended change nothing.
        """
        now = monotonic()
        if press > self._press:
            self._press, self._drives, self._least = press, True, math.inf
        elif press < self._press or not self._drives:
            return
        self._least = min(self._least, now - at)
        if now - at - self._least > LATE_S:
            self._lose('The connection is slow: the robot was stopped. Let the pad go, and hold it again.')
            return
        self._wait()
        self._send(_limit(ahead), _limit(left))

    def release(self) -> None:
        """Stop the robot if it follows the hand: the pad was let go, or is gone."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._drives:
            self._drives = False
            self._send(0.0, 0.0)

    def _wait(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = asyncio.get_running_loop().call_later(
            SILENT_S, self._lose, 'The page fell silent: the robot was stopped.'
        )

    def _lose(self, reason: str) -> None:
        self.release()
        self._on_lost(reason)


def _limit(fraction: float) -> float:
    return max(-1.0, min(1.0, fraction)) if math.isfinite(fraction) else 0.0


def twist_values(type_name: str, ahead: float, left: float) -> dict[str, Any]:
    """Return a Twist or TwistStamped: m/s ahead, and rad/s to the left."""
    twist = {'linear': {'x': ahead, 'y': 0.0, 'z': 0.0}, 'angular': {'x': 0.0, 'y': 0.0, 'z': left}}
    if type_name == TWIST_STAMPED:
        return {'header': {'stamp': 'now', 'frame_id': ''}, 'twist': twist}
    return twist

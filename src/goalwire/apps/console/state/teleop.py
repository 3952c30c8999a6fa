"""Drives a robot by hand: it moves only while a hand holds the pad, and while that hand is heard in time.

A hand that lets go, falls silent or is heard late stops the robot, and so does STOP. After all but the first
the pad must be let go and held again.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from time import monotonic
from typing import Any

SILENT_S = 0.35
"""Seconds without a command after which the hand counts as lost; it sends one each 0.1 s."""
LATE_S = 0.4
"""Seconds by which a command may come later than the quickest one of the same press.

The page itself lets the pad go if the console does not answer its commands: so a connection that is slow all
the time stops the robot, too.
"""
_REPEATS_S = (0.1, 0.2, 0.3)
"""When a stop is sent again: a listener may lose one message."""
TWIST = 'geometry_msgs/msg/Twist'
TWIST_STAMPED = 'geometry_msgs/msg/TwistStamped'


class Teleops:
    """The hands that drive robots from this console: one for each topic."""

    def __init__(self) -> None:
        self._driving: dict[str, Teleop] = {}

    def take(self, topic: str, hand: Teleop) -> bool:
        """Let a hand drive by a topic; False if another one does."""
        return self._driving.setdefault(topic, hand) is hand

    def give_back(self, hand: Teleop) -> None:
        """Note that a hand drives no more."""
        self._driving = {topic: other for topic, other in self._driving.items() if other is not hand}

    def stop(self, reason: str = '') -> None:
        """Stop what all hands drive, and tell them why, if there is a reason to tell."""
        for hand in list(self._driving.values()):
            if reason:
                hand.lose(reason)
            else:
                hand.release()


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
        self._timers: list[asyncio.TimerHandle] = []

    @property
    def drives(self) -> bool:
        """True while the robot follows the hand."""
        return self._drives

    def is_new(self, press: float) -> bool:
        """True for a press of which no command has come."""
        return press > self._press

    def hold(self, press: float, at: float, ahead: float, left: float) -> None:
        """Take a command of the hand, which holds the pad there.

        `press` counts the presses of the pad upwards. `at` is the time since this press began, in s by the
        browser's clock. Commands of a press that has ended change nothing.
        """
        if not all(map(math.isfinite, (press, at, ahead, left))):
            return
        now = monotonic()
        if self.is_new(press):
            self._press, self._drives, self._least = press, True, math.inf
        elif press < self._press or not self._drives:
            return
        self._least = min(self._least, now - at)
        if now - at - self._least > LATE_S:
            self.lose('The connection is slow: the robot was stopped. Let the pad go, and hold it again.')
            return
        self._cancel_timers()
        self._later(SILENT_S, lambda: self.lose('The page fell silent: the robot was stopped.'))
        self._send(_limit(ahead), _limit(left))

    def release(self) -> None:
        """Stop the robot if it follows the hand: the pad was let go, or is gone."""
        if self._drives:
            self._cancel_timers()
            self._drives = False
            for seconds in _REPEATS_S:
                self._later(seconds, lambda: self._send(0.0, 0.0))
            self._send(0.0, 0.0)

    def lose(self, reason: str) -> None:
        """Stop the robot if it follows the hand, and tell the hand why."""
        if self._drives:
            self.release()
            self._on_lost(reason)

    def _later(self, seconds: float, do: Callable[[], object]) -> None:
        self._timers.append(asyncio.get_running_loop().call_later(seconds, do))

    def _cancel_timers(self) -> None:
        for timer in self._timers:
            timer.cancel()
        self._timers.clear()


def _limit(fraction: float) -> float:
    return max(-1.0, min(1.0, fraction))


def within(limit: float | None, most: float) -> float:
    """Return a limit from 0 to `most`: a field keeps what is typed until it loses the focus."""
    return max(0.0, min(float(limit or 0.0), most))


def twist_values(type_name: str, ahead: float, left: float) -> dict[str, Any]:
    """Return a Twist or TwistStamped: m/s ahead, and rad/s to the left."""
    twist = {'linear': {'x': ahead, 'y': 0.0, 'z': 0.0}, 'angular': {'x': 0.0, 'y': 0.0, 'z': left}}
    if type_name == TWIST_STAMPED:
        return {'header': {'stamp': 'now', 'frame_id': ''}, 'twist': twist}
    return twist

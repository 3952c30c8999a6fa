"""Timestamps of a session: each later than all before it, also where the clock is set back.

A timestamp counts 2^32 to a second. Here its 14 lowest bits count the stamps within one unit of 3.8 µs, the
next 14 the units; all others change 16 times a second, and are encoded that often. So a stamp takes small
numbers, and of its tables neighbours are used: 0.4 µs, where the exact time took 1.2.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import RLock

from goalwire.zenoh.protocol.primitives import PADDED_LOW, SMALL_END, encode_timestamp, ntp64

_SLOT_NS = 62_500_000
"""A sixteenth of a second: 2^28 of a timestamp, exactly."""
_UNIT_NS = 3815
"""A little more than 2^14 of a timestamp: those of a slot have room in it."""
_FIRST_BYTES = 4
"""Bytes of an encoded time that hold the units and what is below."""

PAUSE_NS = 50_000
"""So long after the last one a message begins a burst of its own. A flood has one each 3-10 µs."""
LONG_BURST = 256
"""How many stamps of a burst are counted at most."""


class Stamps:
    """The timestamps of one session. Any thread."""

    def __init__(self, zid: bytes, wall_clock_ns: Callable[[], int]) -> None:
        self.burst = 0
        """How many stamps were made without a pause between any two; after a pause a quarter still counts.

        For the pause may be the system's: on a busy machine a thread that floods is often stopped.
        """
        self._zid = zid
        self._wall_clock_ns = wall_clock_ns
        lock = RLock()  # re-entrant: a signal's handler may publish while the same thread does
        self._acquire, self._release = lock.acquire, lock.release
        self._last_ns = 0
        self._slot_ns = -_SLOT_NS
        self._unit = self._count = 0
        self._rest = b''

    def next(self) -> bytes:
        """Return an encoded timestamp later than any before it."""
        try:
            self._acquire()  # as in `Outgoing.send`
            now = self._wall_clock_ns()
            if now - self._last_ns >= PAUSE_NS:
                self.burst >>= 2
            elif self.burst < LONG_BURST:
                self.burst += 1
            self._last_ns = now
            passed = now - self._slot_ns
            unit = passed // _UNIT_NS if passed < _SLOT_NS else self._enter(now)
            if unit > self._unit:
                self._unit, self._count = unit, 0
            else:  # in the same unit, or the clock was set back
                self._count += 1
                # More than one if a signal's handler makes stamps here meanwhile
                if self._count >= SMALL_END:
                    self._go_on()
            return PADDED_LOW[self._count] + PADDED_LOW[self._unit] + self._rest
        finally:
            try:  # noqa: SIM105
                self._release()
            except RuntimeError:
                pass

    def _enter(self, now: int) -> int:
        """Go on to the slot that `now` is in; return its unit."""
        passed = now % _SLOT_NS
        slot_ns = now - passed
        rest = encode_timestamp(ntp64(slot_ns), self._zid)[_FIRST_BYTES:]
        if slot_ns > self._slot_ns:  # a signal's handler may have been here meanwhile
            self._rest, self._slot_ns, self._unit, self._count = rest, slot_ns, -1, -1
        return passed // _UNIT_NS

    def _go_on(self) -> None:
        """Take the next unit, whatever the clock shows: all stamps of this one are used."""
        self._count = 0
        self._unit += 1
        if self._unit >= SMALL_END:
            self._enter(self._slot_ns + _SLOT_NS)
            self._unit, self._count = max(self._unit, 0), self._count + 1

"""Timestamps of a session: each is later than every earlier one, even if the clock is set back.

A timestamp counts in units of 2^-32 s. Here its 14 lowest bits count the stamps within a unit of 3.8 µs, and
the next 14 bits count these units. All higher bits change only 16 times a second, and are encoded that often.
The lower ones are looked up in tables. So a stamp takes 0.5 µs; encoding the exact time took 1.2 µs.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import RLock

from goalwire.zenoh.protocol.primitives import FOLLOWED, encode_timestamp, ntp64

_SLOT_NS = 62_500_000
"""A slot: a sixteenth of a second, exactly 2^28 counts of a timestamp."""
_UNIT_NS = 3815
"""A little more than 2^14 counts of a timestamp, so that a slot has at most 2^14 units."""
_UNITS = 1 << 14
"""The most units in a slot: numbers of two groups of seven bits."""
_STAMPS = 1 << 7
"""The most stamps in a unit."""
_COUNTS = [group + FOLLOWED[0] for group in FOLLOWED]
"""The encoded counts of stamps within a unit."""
_FIRST_BYTES = 4
"""Bytes of an encoded time that hold the 28 lowest bits."""

PAUSE_NS = 50_000
"""A message so long after the last one begins a new burst. Messages of a flood are 3-10 µs apart."""
LONG_BURST = 256
"""The highest count of stamps in a burst."""


class Stamps:
    """The timestamps of one session. Any thread."""

    def __init__(self, zid: bytes, wall_clock_ns: Callable[[], int]) -> None:
        self.burst = 0
        """The number of stamps in a row without a pause. A pause divides it by four.

        It does not become 0, since a busy machine often stops a flooding thread for a moment.
        """
        self._zid = zid
        self._wall_clock_ns = wall_clock_ns
        lock = RLock()  # re-entrant: a signal's handler may publish while its thread publishes
        self._acquire, self._release = lock.acquire, lock.release
        self._last_ns = 0
        self._slot_ns = -_SLOT_NS
        self._unit = self._count = 0
        self._rest = b''
        self._high, self._tail = -1, b''
        """The upper seven bits of a unit, and an encoded stamp from these bits on."""

    def next(self) -> bytes:
        """Return an encoded timestamp that is later than every earlier one."""
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
            else:  # `now` is in the same unit, or the clock was set back
                self._count += 1
                # `>=`: a signal's handler may have made further stamps here
                if self._count >= _STAMPS:
                    self._go_on()
            unit = self._unit
            if unit >> 7 != self._high:
                self._tail, self._high = FOLLOWED[unit >> 7] + self._rest, unit >> 7
            return _COUNTS[self._count] + FOLLOWED[unit & 0x7F] + self._tail
        finally:
            try:  # noqa: SIM105
                self._release()
            except RuntimeError:
                pass

    def _enter(self, now: int) -> int:
        """Change to the slot that contains `now`; return the unit of `now`."""
        passed = now % _SLOT_NS
        slot_ns = now - passed
        rest = encode_timestamp(ntp64(slot_ns), self._zid)[_FIRST_BYTES:]
        if slot_ns > self._slot_ns:  # a signal's handler may have changed to this slot meanwhile
            self._rest, self._slot_ns, self._unit, self._count, self._high = rest, slot_ns, -1, -1, -1
        return passed // _UNIT_NS

    def _go_on(self) -> None:
        """Go on to the next unit, whatever the clock shows: all stamps of the current unit are used up."""
        self._count = 0
        self._unit += 1
        if self._unit >= _UNITS:
            self._enter(self._slot_ns + _SLOT_NS)
            self._unit, self._count = max(self._unit, 0), self._count + 1

"""The clocks of the computer on which a runner runs, and the id of its current boot."""

from __future__ import annotations

import time
from functools import cache

from goalwire.files import read_regular
from goalwire.rules.missions.holding import Sighting

_BOOT_ID = '/proc/sys/kernel/random/boot_id'
_LARGEST = 100
_BOOT_ACCURACY_S = 60


class ThisComputer:
    """This computer. A test can replace it by one that reboots on demand."""

    @property
    def boot(self) -> str:
        """A text that differs between boots. If the system has no boot id, it is the time of the boot.

        That time changes when the clock is set: then missions wait for a person although it is not necessary.
        """
        return _kernel_boot_id() or f'{(time.time() - time.monotonic()) // _BOOT_ACCURACY_S:.0f}'

    def steady(self) -> float:
        """Return the time in s by a clock that never jumps within one boot."""
        return time.monotonic()

    def wall(self) -> float:
        """Return the time in s since 1970, by a clock that may jump."""
        return time.time()

    def sighting(self) -> Sighting:
        """Return the current boot and times, for `why_held`."""
        return Sighting(self.boot, self.steady())


@cache
def _kernel_boot_id() -> str:
    try:
        return read_regular(_BOOT_ID, _LARGEST).decode().strip()
    except OSError:
        return ''

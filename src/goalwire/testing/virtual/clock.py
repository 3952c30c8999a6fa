"""Virtual time: hours take milliseconds, and everything happens in the same order each time."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from goalwire.errors import LocalError
from goalwire.testing.virtual.installing import Installation
from goalwire.testing.virtual.scheduler import Scheduler
from goalwire.testing.virtual.stand_ins import Running

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

_STEADY_NS = 1_000_000_000_000
"""The steady time in ns at the beginning: not 0, which some programs treat as 'never'."""

_EPOCH_NS = 1_767_225_600_000_000_000
"""The system time in ns since 1970 at the beginning: 2026-01-01 00:00 UTC."""


class VirtualClock:
    """`with VirtualClock():` begins virtual time for the thread that enters the block and for threads it
    starts.

    In these threads `time` and `threading`, queues and asyncio's loops, and all of rclpy and goalwire use
    virtual time: it stands still while any of the threads runs, and jumps to the next deadline when all of
    them wait. If there is no deadline, the thread of the block gets a DeadlockError. A process can have one
    VirtualClock at a time.
    """

    def __init__(self) -> None:
        self._scheduler: Scheduler | None = None
        self._installation: Installation | None = None
        self._end_ns = _STEADY_NS

    @property
    def elapsed(self) -> float:
        """Virtual time in s since the beginning of the block; after the block, its duration."""
        now = self._end_ns if self._scheduler is None else self._scheduler.now
        return (now - _STEADY_NS) / 1e9

    def __enter__(self) -> Self:
        """Begin virtual time. Raises LocalError inside the block of another VirtualClock."""
        if Running.scheduler is not None:
            raise LocalError('a virtual clock runs already in this process: leave its block first')
        self._scheduler = Scheduler(threading.current_thread(), _STEADY_NS)
        Running.epoch_ns = _EPOCH_NS - _STEADY_NS
        Running.scheduler = self._scheduler
        self._installation = Installation()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        assert self._scheduler is not None
        assert self._installation is not None
        self._installation.remove()
        Running.scheduler = None
        self._end_ns = self._scheduler.now
        self._scheduler.close()
        self._scheduler = self._installation = None

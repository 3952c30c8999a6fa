"""The last second of a deleted writer, in which its readers may still acknowledge and request samples."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.rtps.protocol.wire import Wire
from goalwire.rtps.protocol.writer_output import WriterOutput

LINGER_S = 1.0
"""How long a deleted writer waits for acknowledgements: as Cyclone DDS's (Internal/WriterLingerDuration)."""


def is_delivered(output: WriterOutput) -> bool:
    """Tell whether other participants' readers that have ever answered have all samples of a writer.

    Readers of its own participant take a sample while it is written. May be called on any thread.
    """
    others = [proxy for proxy in tuple(output.reliable) if proxy.has_answered and proxy.address[1]]
    return all(output.has_all(proxy) for proxy in others)


class Lingering:
    """Calls `end` once all samples of a deleted writer are delivered, or after `LINGER_S`.

    All methods, and `end`, are called inside `Wire.run`.
    """

    def __init__(self, wire: Wire, output: WriterOutput, end: Callable[[], None]) -> None:
        self._wire = wire
        self._output = output
        self._timer = wire.timers.at(wire.clock() + LINGER_S, end)

    def note_acknowledged(self) -> None:
        """Take note that a reader has acknowledged samples, or has gone."""
        end = self._timer.function
        if end is not None and is_delivered(self._output):
            self._timer.cancel()
            # A moment later: this may run in a loop over the readers, which the end forgets.
            self._timer = self._wire.timers.at(self._wire.clock(), end)

    def stop(self) -> None:
        """Do not call `end` any more."""
        self._timer.cancel()

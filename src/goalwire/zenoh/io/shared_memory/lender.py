"""The writer's side of one link: tests which segments the reader can read, and lends chunks to it."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

from goalwire.zenoh.io.shared_memory.pool import Chunk, Lent, MemoryPool
from goalwire.zenoh.protocol.bodies import shared_put_head
from goalwire.zenoh.protocol.network import push_head, wire_key
from goalwire.zenoh.protocol.shared_memory import Loan, Pointer, encode_pointer

PROBE_KEY = '@goalwire/probe'
"""The key of probes. No subscriber gets them: wildcards match no part of a key that begins with @."""
PATIENCE_S = 5.0
"""How long a probe may stay unreturned before the log warns that the reader does not read."""


class _Probe:
    """A chunk of one data segment that was lent to see whether the reader can open that segment."""

    def __init__(self, pointer: Pointer) -> None:
        self.pointer = pointer
        self.sent_at = monotonic()
        self.is_told = False


class Lender:
    """Lends chunks over one link. A data segment is used only after the reader has returned a probe of it.

    A C++ reader locks each segment in memory. If its limit is too low, it agrees to shared memory and then
    drops every message silently. The probe detects this before a message is lost.
    """

    def __init__(
        self, pool: MemoryPool, lent: Lent, send: Callable[[bytes], object], warn: Callable[[str], None]
    ) -> None:
        self._pool = pool
        self._lent = lent
        self._send = send
        self._warn = warn
        self._probes: dict[int, _Probe | None] = {}
        """The probe of each data segment; None once the probe has come back."""

    def lend(self, chunk: Loan) -> Pointer | None:
        """Return a pointer to a chunk; None if this message must go as bytes."""
        if not isinstance(chunk, Chunk):
            return None
        number = chunk.segment.file.number
        if number not in self._probes:
            self._begin_probe(chunk.segment.probe, number)
            return None
        probe = self._probes[number]
        if probe is not None:
            if not self._pool.is_back(probe.pointer):
                self._tell_late(probe)
                return None
            self._probes[number] = None
        return self._pool.lend(chunk, self._lent)

    def take_back(self, pointer: Pointer) -> None:
        """Take back a pointer that was not sent."""
        self._pool.take_back(pointer, self._lent)

    def _begin_probe(self, chunk: Chunk, number: int) -> None:
        """Lend the probe of a data segment, on a key that nobody subscribes to."""
        pointer = self._pool.lend(chunk, self._lent)
        if pointer is None:
            return
        self._probes[number] = _Probe(pointer)
        head = push_head(wire_key(PROBE_KEY), 5)
        if not self._send(b''.join((head, shared_put_head(None, None, None), encode_pointer(pointer)))):
            self._pool.take_back(pointer, self._lent)
            del self._probes[number]

    def _tell_late(self, probe: _Probe) -> None:
        """Warn once if the reader has not returned the probe in time."""
        if not probe.is_told and monotonic() - probe.sent_at > PATIENCE_S:
            probe.is_told = True
            self._warn(
                'it agreed to share memory and does not read it, so it gets large messages over its socket; '
                'its limit of locked memory may be too low (ulimit -l)'
            )

    def close(self) -> None:
        """Give the lent chunks up: the link has ended."""
        self._pool.give_up(self._lent)

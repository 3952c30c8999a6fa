"""The shared memory of one session: the links it is offered on, its segments, and their end."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from contextlib import suppress
from threading import RLock
from weakref import WeakSet

from goalwire.concurrency.forks import ForkGuard, in_child, reset_in_children
from goalwire.fault_reports import LOGGER
from goalwire.zenoh.io.settings import MemorySettings
from goalwire.zenoh.io.shared_memory.agreement import Agreement, OwnAuth, Partner
from goalwire.zenoh.io.shared_memory.lender import Lender
from goalwire.zenoh.io.shared_memory.pool import Chunk, MemoryPool
from goalwire.zenoh.io.shared_memory.reader import MakeAtomic, MemoryReader, find_atomics
from goalwire.zenoh.io.shared_memory.segments import IS_SUPPORTED, sweep
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.shared_memory import Loan, Pointer


class LinkMemory:
    """The shared memory of one link; see `protocol.shared_memory.LinkMemory`."""

    def __init__(self, lender: Lender | None, reader: MemoryReader, partner: Partner) -> None:
        """If `lender` is None, the other side gets bytes."""
        self._lender = lender
        self._reader = reader
        self._partner = partner
        self.take = reader.take

    def lend(self, loan: Loan) -> Pointer | None:
        """Return a pointer for the other side; None if this message must go as bytes."""
        if self._lender is None or not isinstance(loan, Chunk):
            return None
        return self._lender.lend(loan)

    def take_back(self, pointer: Pointer) -> None:
        """Take back a pointer that was not sent."""
        if self._lender is not None:
            self._lender.take_back(pointer)

    def close(self) -> None:
        """Close both directions: the link has ended."""
        self._reader.close()
        if self._lender is not None:
            self._lender.close()
        else:
            self._partner.segment.close()


_swept: list[bool] = []
in_child(_swept.clear)


class SessionMemory:
    """The shared memory of one session. It makes its segments when the first link can use them."""

    def __init__(self, settings: MemorySettings, session: str, guard: ForkGuard) -> None:
        """`session` is the id that log lines begin with."""
        self.least = settings.least
        """Bytes of the smallest payload that goes through shared memory."""
        self._settings = settings
        self._session = session
        self._guard = guard
        self._lock = RLock()
        self._own: OwnAuth | None = None
        self._make_atomic: MakeAtomic | None = None
        self.pool: MemoryPool | None = None
        """The memory from which the session publishes; None as long as no link could use it."""
        self._readers: WeakSet[MemoryReader] = WeakSet()
        self._odd: set[int] = set()
        """The handshake segments of partners that have shared invalid memory: they get bytes from then on."""
        self._is_on = IS_SUPPORTED and (settings.with_own or settings.with_all)
        reset_in_children(self)

    def agreement(self, sock: socket.socket, protocol: str) -> Agreement | None:
        """Return the agreement that a new link negotiates; None if the link is to carry bytes only.

        A link with TLS carries bytes: other processes could read shared memory. Without `with_all`, memory is
        offered only to peers with the same address.
        """
        if not self._is_on or protocol != 'tcp' or not (self._settings.with_all or _is_local(sock)):
            return None
        own = self._open()
        return None if own is None else Agreement(own, self._admits, self._make_link)

    def borrow(self, size: int) -> Chunk | None:
        """Return a chunk to publish from; None if there is no room, or no link that could use it."""
        return None if self.pool is None else self.pool.borrow(size)

    def _admits(self, partner: Partner) -> bool:
        if partner.number in self._odd:
            return False
        return self._settings.with_all or (partner.is_goalwire and self._settings.with_own)

    def _note_odd(self, partner: Partner) -> None:
        self._odd.add(partner.number)

    def _open(self) -> OwnAuth | None:
        """Make the session's segments for the first link that can use them; sweep orphans first."""
        with self._lock:
            if self._own is None and self._is_on:
                if not _swept:
                    _swept.append(True)
                    with suppress(OSError):
                        sweep()
                self._make_atomic = find_atomics() if self._settings.with_all else None
                try:
                    own = OwnAuth(os.urandom, reads_all=self._make_atomic is not None)
                except OSError as error:
                    self._is_on = False
                    self._warn(f'no shared memory is available ({error.strerror or error}): it sends bytes')
                    return None
                self._own = own
                self.pool = MemoryPool(self._settings.pool_size, self._settings.least, own.number, self._warn)
            return self._own

    def _make_link(
        self, partner: Partner, counters: tuple[int, ...], send: Callable[[bytes], object]
    ) -> LinkMemory:
        """Make the memory of one link. Lending needs a reader that can read goalwire's headers."""
        lender = None
        if self.pool is not None and (partner.reads_all or partner.is_goalwire):
            lender = Lender(self.pool, self.pool.add_reader(partner.segment), send, self._warn)
        reader = MemoryReader(
            partner,
            counters,
            self._own,
            self._make_atomic,
            lambda: self._guard.is_forked,
            bounds.MESSAGE_LIMIT,
            self._note_odd,
        )
        self._readers.add(reader)
        return LinkMemory(lender, reader, partner)

    def _warn(self, text: str) -> None:
        from goalwire.logging import get_logger  # imported here, since it is needed only after a fault

        get_logger(LOGGER).warning(f'Zenoh session {self._session}: shared memory: {text}')

    def close(self) -> None:
        """Remove the segments."""
        with self._lock:
            self._is_on = False
            own, self._own = self._own, None
        if self.pool is not None:
            self.pool.close()
        if own is None:
            return
        if any(reader.has_views() for reader in self._readers):
            # the views keep the segment locked, so that the writers do not reuse their chunks
            own.segment.unlink()
        else:
            own.segment.close()

    def reset_in_child(self) -> None:
        """In a forked child: close the descriptors; the segments are the parent's."""
        self._is_on = False
        if self.pool is not None:
            self.pool.abandon()
        if self._own is not None:
            self._own.segment.abandon()


def _is_local(sock: socket.socket) -> bool:
    """True if both ends of a connection have the same address."""
    try:
        return bool(sock.getsockname()[0] == sock.getpeername()[0])
    except OSError:
        return False

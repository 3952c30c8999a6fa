"""The shared memory of one session: the links it is offered on, its segments, and their end."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from threading import RLock
from typing import TYPE_CHECKING

from goalwire.concurrency.forks import ForkGuard, in_child, reset_in_children
from goalwire.fault_reports import LOGGER
from goalwire.weak_members import WeakMembers
from goalwire.zenoh.io.settings import MemorySettings
from goalwire.zenoh.io.shared_memory.agreement import Agreement, OwnAuth, Partner
from goalwire.zenoh.io.shared_memory.segments import IS_SUPPORTED, sweep
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.shared_memory import Loan, Pointer, Slices

if TYPE_CHECKING:
    from goalwire.zenoh.io.shared_memory.lender import Lender
    from goalwire.zenoh.io.shared_memory.pool import Chunk, MemoryPool
    from goalwire.zenoh.io.shared_memory.reader import MakeAtomic, MemoryReader


class LinkMemory:
    """The shared memory of one link; see `protocol.shared_memory.LinkMemory`.

    Most links never carry a large message, so each direction is made at its first one. The link may end in
    one thread while another reads: so both hold the lock.
    """

    def __init__(
        self,
        partner: Partner,
        make_lender: Callable[[], Lender | None],
        make_reader: Callable[[], MemoryReader],
    ) -> None:
        """`make_lender` returns None if the other side gets bytes."""
        self._partner = partner
        self._make_lender = make_lender
        self._make_reader = make_reader
        self._lock = RLock()
        self._lender: Lender | None = None
        self._reader: MemoryReader | None = None
        self._may_lend = True
        self._is_open = True

    def lend(self, loan: Loan) -> Pointer | None:
        """Return a pointer for the other side; None if this message must go as bytes."""
        lender = self._lender or self._begin_lending()
        return None if lender is None else lender.lend(loan)

    def take_back(self, pointer: Pointer) -> None:
        """Take back a pointer that was not sent."""
        if self._lender is not None:
            self._lender.take_back(pointer)

    def take(self, slices: Slices, priority: int, *, as_view: bool) -> bytes | memoryview | None:
        """Return the payload of a received message, as `MemoryReader.take` does; None if the link ended."""
        with self._lock:
            reader = self._begin_reading()
            if reader is None:
                return None
            try:
                return reader.take(slices, priority, as_view=as_view)
            finally:
                if not self._is_open:  # a signal's handler has closed it meanwhile
                    reader.close()

    def _begin_lending(self) -> Lender | None:
        with self._lock:
            if self._may_lend and self._lender is None:
                self._lender = self._make_lender()
                self._may_lend = self._lender is not None
            return self._lender

    def _begin_reading(self) -> MemoryReader | None:
        if self._is_open and self._reader is None:
            self._reader = self._make_reader()
        return self._reader if self._is_open else None

    def close(self) -> None:
        """Close both directions: the link has ended."""
        with self._lock:
            self._may_lend = self._is_open = False
            if self._reader is not None:
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
        """The memory from which the session publishes; None before its first large message."""
        self._readers: WeakMembers[MemoryReader] = WeakMembers()
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
        if self._own is None:
            return None
        pool = self.pool or self._make_pool()
        return None if pool is None else pool.borrow(size)

    def _make_pool(self) -> MemoryPool | None:
        from goalwire.zenoh.io.shared_memory.pool import MemoryPool

        with self._lock:
            if self.pool is None and self._own is not None:
                self.pool = MemoryPool(
                    self._settings.pool_size, self._settings.least, self._own.number, self._warn
                )
            return self.pool

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
                if self._settings.with_all:
                    from goalwire.zenoh.io.shared_memory.reader import find_atomics

                    self._make_atomic = find_atomics()
                try:
                    own = OwnAuth(os.urandom, reads_all=self._make_atomic is not None)
                except OSError as error:
                    self._is_on = False
                    self._warn(f'no shared memory is available ({error.strerror or error}): it sends bytes')
                    return None
                self._own = own
            return self._own

    def _make_link(
        self, partner: Partner, counters: tuple[int, ...], send: Callable[[bytes], object]
    ) -> LinkMemory:
        return LinkMemory(
            partner, partial(self._make_lender, partner, send), partial(self._make_reader, partner, counters)
        )

    def _make_lender(self, partner: Partner, send: Callable[[bytes], object]) -> Lender | None:
        """Make the writer's side of a link; None if its reader cannot read goalwire's headers."""
        from goalwire.zenoh.io.shared_memory.lender import Lender

        if self.pool is None or not (partner.reads_all or partner.is_goalwire):
            return None
        return Lender(self.pool, self.pool.add_reader(partner.segment), send, self._warn)

    def _make_reader(self, partner: Partner, counters: tuple[int, ...]) -> MemoryReader:
        from goalwire.zenoh.io.shared_memory.reader import MemoryReader

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
        return reader

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
        if any(reader.has_views() for reader in self._readers.alive()):
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

"""How the two sides of a link agree on shared memory: each proves that it can read the other's segment.

    connector: INIT: my segment        -->   acceptor: reads its challenge
               <-- INIT: your challenge, my segment
               OPEN: your challenge    -->             compares it
               <-- OPEN: agreed

A side that cannot open the other's segment (another machine, another user, another container) says nothing,
and the link carries bytes. Zenoh until 1.9 and Zenoh since 1.10 store the challenge differently and write
OPEN differently. The two versions do not share memory with each other. This side uses the form of its
partner.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from struct import Struct
from threading import RLock
from typing import NamedTuple

from goalwire.zenoh.io.shared_memory import layout
from goalwire.zenoh.io.shared_memory.segments import ForeignSegment, OwnSegment
from goalwire.zenoh.protocol.primitives import Reader, ZenohProtocolError, encode_z
from goalwire.zenoh.protocol.shared_memory import LinkMemory

_NO_COUNTERS = b'\0'
"""In OPEN: this side lends no counters. It needs none, as the counts in its headers show what was read."""
PRIORITIES = 8


class OwnAuth:
    """This session's segment for the handshake: whoever returns its challenge can read our memory."""

    def __init__(self, random: Callable[[int], bytes], *, reads_all: bool) -> None:
        """With `reads_all` this side accepts pointers of any writer. Raises OSError."""
        self.segment = OwnSegment(layout.AUTH_SIZE, 32)
        self.number = self.segment.number
        self.challenge = int.from_bytes(random(8), 'little')
        layout.AUTH_HEAD.pack_into(self.segment.map, 0, int(reads_all), self.challenge, layout.VERSION)
        layout.MARK.pack_into(
            self.segment.map, layout.MARK_AT, layout.MAGIC, layout.READS_OWN_HEADERS, self.number
        )


class Partner(NamedTuple):
    """The other side, as its segment describes it."""

    segment: ForeignSegment
    version: int
    challenge: int
    reads_all: bool
    """True if the other side accepts pointers of any writer to segments in /dev/shm."""
    is_goalwire: bool

    @property
    def number(self) -> int:
        """The number of the other side's segment for the handshake."""
        return self.segment.number


def read_partner(number: int) -> Partner:
    """Read the other side's segment. Raises OSError or ValueError if it cannot be read."""
    segment = ForeignSegment(number, writable=True)
    try:
        return _read(segment)
    except BaseException:
        segment.close()
        raise


def _read(segment: ForeignSegment) -> Partner:
    """Read the older form or the newer one; the version and the size show which it is."""
    data = segment.read(layout.AUTH_SIZE, 0)
    if len(data) < layout.AUTH_HEAD.size or len(data) != segment.size:
        raise ValueError(f'a segment of {segment.size} bytes')
    count, challenge, version = layout.AUTH_HEAD.unpack_from(data)
    if version == layout.VERSION and segment.size == layout.AUTH_SIZE and count <= layout.MOST_PROTOCOLS:
        protocols = Struct(f'={count}I').unpack_from(data, layout.PROTOCOLS_AT)
        magic, abilities, owner = layout.MARK.unpack_from(data, layout.MARK_AT)
        is_goalwire = magic == layout.MAGIC and owner == segment.number
        return Partner(
            segment,
            version,
            challenge,
            layout.POSIX in protocols,
            is_goalwire and bool(abilities & layout.READS_OWN_HEADERS),
        )
    if version == layout.OLD_VERSION and segment.size == layout.PROTOCOLS_AT + 8 * count:
        protocols = Struct(f'={count}Q').unpack_from(data, layout.PROTOCOLS_AT)
        return Partner(segment, version, challenge ^ layout.WORD, layout.POSIX in protocols, False)
    raise ValueError(f'a segment of version {version} with {segment.size} bytes')


class Agreement:
    """The agreement of one link; see `handshake.MemoryAgreement`.

    One thread may close it while another negotiates: whatever is opened then is closed at once.
    """

    def __init__(
        self,
        own: OwnAuth,
        admits: Callable[[Partner], bool],
        make: Callable[[Partner, tuple[int, ...], Callable[[bytes], object]], LinkMemory],
    ) -> None:
        """`admits` returns True if a partner may share memory; `make` makes the memory of a link."""
        self._own = own
        self._admits = admits
        self._make = make
        self._partner: Partner | None = None
        self._counters: tuple[int, ...] = ()
        """The numbers of the counters that the other side has lent, one for each priority."""
        self._is_agreed = False
        self._memory: LinkMemory | None = None
        self._lock = RLock()
        self._is_closed = False

    def offer(self) -> bytes:
        """Return the number of our segment."""
        return encode_z(self._own.number)

    def answer(self, theirs: bytes) -> bytes | None:
        """Return the challenge of the connector's segment, and the number of ours."""
        partner = self._meet(lambda: Reader(theirs).z(32))
        if partner is None:
            return None
        return encode_z(partner.challenge) + encode_z(self._own.number)

    def prove(self, theirs: bytes) -> int | bytes | None:
        """Return the challenge of the acceptor's segment, in the form of the acceptor's Zenoh version."""
        reader = Reader(theirs)
        try:
            echo = reader.z()
        except ZenohProtocolError:
            return None
        partner = self._meet(partial(reader.z, 32))
        if partner is None or echo != self._read_challenge(partner):
            self.close()
            return None
        if partner.version == layout.OLD_VERSION:
            return partner.challenge
        return encode_z(partner.challenge) + _NO_COUNTERS

    def accept(self, proof: int | bytes | None) -> int | bytes | None:
        """Return our acceptance if the proof shows that the connector has read our segment."""
        partner = self._partner
        if partner is None:
            return None
        try:
            if partner.version == layout.OLD_VERSION:
                self._is_agreed = proof == self._read_challenge(partner)
                return 1 if self._is_agreed else None
            reader = Reader(proof if isinstance(proof, bytes) else b'')
            self._is_agreed = reader.z() == self._read_challenge(partner)
            self._counters = _read_counters(reader)
        except ZenohProtocolError:
            self._is_agreed = False
        return _NO_COUNTERS if self._is_agreed else None

    def conclude(self, accepted: int | bytes | None) -> None:
        """Read the acceptor's acceptance."""
        partner = self._partner
        if partner is None or accepted is None:
            return
        if partner.version == layout.OLD_VERSION:
            self._is_agreed = accepted == 1
        elif isinstance(accepted, bytes):
            try:
                self._counters = _read_counters(Reader(accepted))
                self._is_agreed = True
            except ZenohProtocolError:
                self._is_agreed = False

    def make_memory(self, send: Callable[[bytes], object]) -> LinkMemory | None:
        """Return the memory of the link; None if the sides have not agreed."""
        with self._lock:
            partner = self._partner
            if partner is None or not self._is_agreed:
                self.close()
                return None
            self._memory = self._make(partner, self._counters, send)
            return self._memory

    def close(self) -> None:
        """Close the other side's segment: the link has ended, or carries bytes."""
        with self._lock:
            self._is_closed = True
            partner, self._partner = self._partner, None
        if self._memory is not None:
            self._memory.close()
        elif partner is not None:
            partner.segment.close()

    def _meet(self, read_number: Callable[[], int]) -> Partner | None:
        """Open the other side's segment; None if it cannot be read, or that side may not share memory."""
        try:
            partner = read_partner(read_number())
        except (OSError, ValueError, ZenohProtocolError):
            return None
        if self._admits(partner):
            with self._lock:
                if not self._is_closed:
                    self._partner = partner
                    return partner
        partner.segment.close()
        return None

    def _read_challenge(self, partner: Partner) -> int:
        """Return our challenge as the other side reads it in our segment."""
        own = self._own.challenge
        return own ^ layout.WORD if partner.version == layout.OLD_VERSION else own


def _read_counters(reader: Reader) -> tuple[int, ...]:
    """Return the counters that a side lends, none or one for each priority. Raises ZenohProtocolError."""
    if not reader.u8():
        return ()
    counters = tuple(reader.z(16) for _ in range(PRIORITIES))
    if max(counters) >= layout.COUNTERS:
        raise ZenohProtocolError(f'counter {max(counters)} of {layout.COUNTERS}')
    return counters

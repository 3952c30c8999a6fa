"""The receiving half of a link: cuts batches of bytes into frames and pieces, and these into messages.

TCP delivers bytes cut at any place. A batch begins with its length, and holds one or more messages of the
link itself. Among these are frames, which hold network messages, and fragments of network messages. Frames
and fragments have numbers, so a repeated frame is ignored. `link` takes the network messages and the messages
of the handshake.
"""

from __future__ import annotations

from collections.abc import Callable, Container

from goalwire.errors import RemoteError
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.channels import (
    DATA_CHANNEL,
    DATA_PRIORITY,
    IS_FIRST,
    IS_GIVEN_UP,
    IS_RELIABLE,
    MASK,
    MORE_PIECES,
    PRIORITIES,
    PRIORITY_EXTENSION,
    Buffer,
    PieceBudget,
    Reassembly,
    ReceivedNumbers,
)
from goalwire.zenoh.protocol.handshake import Terms
from goalwire.zenoh.protocol.link_messages import (
    CLOSE,
    FIRST_NETWORK_ID,
    FRAGMENT,
    FRAME,
    INIT,
    KEEP_ALIVE,
    MAX_BATCH,
    MESSAGE_ID,
    OPEN,
)
from goalwire.zenoh.protocol.primitives import (
    EXTENSION,
    FOLLOWED,
    MORE,
    Reader,
    ZenohProtocolError,
    encode_padded,
)

MOST_KEPT = 5
"""Limits the memory that an unfinished message keeps, as a multiple of its size."""
_PRIORITY = PRIORITY_EXTENSION & EXTENSION

LENGTH_SIZE = 2
"""Bytes of the length before each batch."""


def _missing(begun: bytes, most: int) -> int:
    """Return how many bytes are missing of a batch that has begun; 0 if unknown, or more than `most`."""
    if len(begun) < LENGTH_SIZE:
        return 0
    missing = LENGTH_SIZE + (begun[0] | begun[1] << 8) - len(begun)
    return missing if missing <= most else 0


class ClosedByPeerError(RemoteError):
    """The other side sent CLOSE: the link ends. This error never reaches a user's program."""


class FrameReader:
    """Reads the bytes of one link. One thread at a time calls it."""

    def __init__(
        self,
        budget: PieceBudget,
        take_handshake: Callable[[Reader], None],
        take_messages: Callable[[bytes, int, int], int],
        refuse: Callable[[str, object], object],
    ) -> None:
        """`budget` limits the unfinished messages of all links; `refuse` counts an ignored message.

        `take_messages` gets data, the start of network messages, and the end of the batch. It returns the end
        of the last network message.
        """
        self.reads = 0
        """The number of calls of `receive` that have ended."""
        self.in_pieces = False
        """True while further pieces of a message are expected."""
        self._take_handshake = take_handshake
        self._take_network = take_messages
        self._refuse = refuse
        self._is_agreed = False
        self._has_priorities = True
        self._marks_first = False
        self._heard = True
        self._largest_batch = MAX_BATCH
        self._tail = b''
        self._numbers = ReceivedNumbers(0)
        self._mask = MASK
        """The mask with all bits of a sequence number set."""
        self._expected = b'none'
        """The first bytes of the expected next frame of reliable data."""
        self._reassembly: dict[int, Reassembly] = {}
        self._pieces = PieceBudget(bounds.MESSAGE_LIMIT, budget)

    def agree(self, terms: Terms) -> None:
        """Apply the terms of the handshake from now on: take frames, and check their numbers."""
        self._has_priorities = terms.qos
        self._marks_first = terms.patch > 0
        self._mask = terms.number_mask
        self._numbers = ReceivedNumbers(terms.first_received, terms.number_mask)
        self._expected = b'%%%b' % encode_padded(terms.first_received)
        self._largest_batch = terms.batch_size - 2
        self._is_agreed = True

    def close(self) -> None:
        """Ignore frames that come from now on."""
        self._is_agreed = False

    def has_heard(self) -> bool:
        """Return True if bytes have come since the last call of this method."""
        heard, self._heard = self._heard, False
        return heard

    def discard_stale(self, now: float) -> int:
        """Throw away unfinished messages whose pieces have stopped coming; return how many bytes they had."""
        freed = 0
        for each in list(self._reassembly.values()):
            size = each.size
            if each.is_stale(now):
                freed += size
                self._refuse('message in pieces', f'its rest did not come within {bounds.STALE_S:g} s')
        return freed

    def discard_pieces(self) -> int:
        """Throw away all unfinished messages; return how many bytes they had."""
        freed = self._pieces.used
        for each in list(self._reassembly.values()):
            each.clear()
        return freed

    def receive(self, data: bytes) -> None:
        """Read received bytes. Raises ZenohProtocolError or ClosedByPeerError; then the link must end."""
        self._heard = True
        # `_tail` is the incomplete batch of earlier reads. Within a large message, only that batch is
        # completed by a copy; otherwise the tail is joined with all of `data`.
        start, tail = 0, self._tail
        if tail:
            if self.in_pieces:
                start = _missing(tail, len(data))
            if not start:
                data = tail + data
        end = len(data)
        try:
            # hot path: of a large message, only one batch in four is copied here, not all received bytes
            if start:
                self._take_batch(tail + data[:start])
            while end - start > 1:
                at = start + 2
                start = at + (data[at - 2] | data[at - 1] << 8)
                # The batch is not complete yet: its beginning is kept for the next read.
                if start > end:
                    start = at - 2
                    break
                if data.startswith(self._expected, at):  # the expected next frame of reliable data
                    last, mask = self._numbers.last, self._mask
                    number = last[DATA_CHANNEL] = (last[DATA_CHANNEL] + 1) & mask
                    number = (number + 1) & mask
                    low = number & 0x7F
                    self._expected = (  # hot path: all bytes but the first stay for 128 messages
                        b'%%%b%b' % (FOLLOWED[low], self._expected[2:])
                        if low
                        else b'%%%b' % encode_padded(number)
                    )
                    at = self._take_network(data, at + 5, start)
                # A batch may have further messages of the link after a frame, such as KEEP_ALIVE.
                while at < start:
                    at = self._take_transport(data, at, start)
        except IndexError:
            raise ZenohProtocolError('a message is cut off') from None
        except UnicodeDecodeError as error:
            raise ZenohProtocolError(f'a text is not UTF-8: {error}') from None
        finally:
            # A signal's handler may raise anywhere above. Then only the rest of the current batch is lost.
            self._tail = data[start:] if start < end else b''
            self.reads += 1

    def _take_batch(self, batch: bytes) -> None:
        """Read a whole batch, which begins with its length."""
        at, end = LENGTH_SIZE, len(batch)
        while at < end:
            at = self._take_transport(batch, at, end)

    def _take_transport(self, data: bytes, at: int, end: int) -> int:
        """Read a message of the link itself; return its end."""
        header = data[at]
        kind = header & MESSAGE_ID
        if end - at > self._largest_batch:
            raise ZenohProtocolError(f'a batch of {end - at} bytes exceeds what was agreed')
        # Frames and KEEP_ALIVE break the protocol before the handshake has ended: the terms are missing.
        if kind in (FRAME, FRAGMENT) and self._is_agreed:
            return self._take_numbered(data, at, end)
        reader = Reader(data, at, end)
        if kind in (INIT, OPEN):
            self._take_handshake(reader)
        elif kind == CLOSE:
            reader.u8()
            raise ClosedByPeerError(f'the other side closed the link (reason {reader.u8()})')
        elif kind == KEEP_ALIVE and self._is_agreed:
            reader.u8()
            if header & MORE:
                reader.extensions()
        else:
            raise ZenohProtocolError(f'message 0x{header:02x} is not expected here')
        return reader.at

    def _take_numbered(self, data: bytes, at: int, end: int) -> int:
        """Read a frame or a piece; return its end.

        Each priority numbers its reliable frames and its best-effort frames separately: these are its two
        channels. A frame is ignored if its number is not ahead of the last one of its channel: it repeats an
        earlier frame.
        """
        header = data[at]
        reader = Reader(data, at + 1, end)
        number = reader.z()
        priority, marks = DATA_PRIORITY, {}
        if header & MORE:
            marks = reader.extensions({_PRIORITY, IS_FIRST, IS_GIVEN_UP})
            named = marks.get(_PRIORITY, DATA_PRIORITY)
            assert isinstance(named, int)
            if _PRIORITY in marks and not self._has_priorities:
                raise ZenohProtocolError(f'priority {named} on a link without priorities')
            if named >= PRIORITIES:
                raise ZenohProtocolError(f'priority {named}, and {PRIORITIES - 1} is the last')
            priority = named
        channel = 2 * priority + bool(header & IS_RELIABLE)
        gap = self._numbers.advance(channel, number)
        # The end of a frame is known only after its messages are read, so the rest of the batch is skipped,
        # too.
        if not gap:
            return end
        if channel == DATA_CHANNEL:
            # `receive` recognises the next frame by these bytes, so most data frames never come here.
            self._expected = b'%%%b' % encode_padded((number + 1) & self._mask)
        if header & MESSAGE_ID == FRAME:
            # A frame between the pieces of a message means that the remaining pieces will not come.
            if channel in self._reassembly:
                self._reassembly[channel].clear()
            return self._take_network(data, reader.at, end)
        # hot path: most pieces of a message of 1 MB are not copied here, which saves 0.1 ms. A view keeps all
        # of `data` in memory, so a piece becomes a view only if it is a large part of `data`.
        start = reader.at
        is_view = (end - start) * MOST_KEPT >= len(data)
        piece = memoryview(data)[start:end] if is_view else data[start:end]
        self._take_piece(channel, piece, gap, marks, more=bool(header & MORE_PIECES))
        return end

    def _take_piece(
        self, channel: int, piece: Buffer, gap: int, marks: Container[int], *, more: bool
    ) -> None:
        """Keep a piece of a message; after the last piece, hand the message on.

        `gap` is the distance to the number before. If it is not 1, a piece was lost, and with it the message.
        """
        reassembly = self._reassembly.get(channel)
        if reassembly is None:
            reassembly = Reassembly(has_marks=self._marks_first, budget=self._pieces)
            self._reassembly[channel] = reassembly
        self.in_pieces = more
        message = reassembly.add(
            piece, gap=gap, first=IS_FIRST in marks, more=more, given_up=IS_GIVEN_UP in marks
        )
        if message is not None:
            # Only network messages may travel in pieces. A message of the link itself is ignored.
            if message[0] & MESSAGE_ID >= FIRST_NETWORK_ID:
                self._take_network(message, 0, len(message))
        elif reassembly.is_refused:
            self._refuse('message in pieces', 'unfinished messages take too much memory')

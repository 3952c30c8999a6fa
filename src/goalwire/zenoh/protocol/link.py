"""One link to another session: parses the bytes that come. What it sends is in `outgoing`.

`receive` takes bytes as they came, in any pieces. It runs the handshake, checks numbers, joins fragments, and
hands each network message to the session. A link is dead when it has heard nothing for the other side's
lease. When it has sent nothing for a quarter of its own lease, it sends KEEP_ALIVE.
"""

from __future__ import annotations

from collections.abc import Callable, Sized
from typing import TYPE_CHECKING, NamedTuple, Protocol

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
from goalwire.zenoh.protocol.declarations import (
    Declaration,
    Interest,
    read_declaration,
    read_interest,
)
from goalwire.zenoh.protocol.forms import (
    KEY_SIZE,
    PushForm,
    ReplyForm,
    RequestForm,
    push_form,
    read_alike_query,
    read_alike_reply,
    reply_form,
    request_form,
)
from goalwire.zenoh.protocol.handshake import Handshake, Terms
from goalwire.zenoh.protocol.key_index import KeyIndex
from goalwire.zenoh.protocol.link_state import LinkStates, Node
from goalwire.zenoh.protocol.network import (
    DECLARE,
    INTEREST,
    IS_SENDERS,
    LARGE,
    OAM,
    PUSH,
    PUT_OF_ROS,
    QOS,
    REQUEST,
    RESPONSE,
    RESPONSE_FINAL,
    Sample,
    new_sample,
    read_body,
    read_extensions,
    read_query,
    read_reply,
    read_request_id,
    read_wire_key,
)
from goalwire.zenoh.protocol.outgoing import QUEUE_END, Outgoing
from goalwire.zenoh.protocol.primitives import (
    EXPIRED,
    EXTENSION,
    MORE,
    PADDED_HIGH,
    PADDED_LOW,
    UNRESPONSIVE,
    Reader,
    ZenohProtocolError,
    decode_z,
    encode_padded,
    encode_session,
)
from goalwire.zenoh.protocol.transport import (
    CLOSE,
    FIRST_NETWORK_ID,
    FRAGMENT,
    FRAME,
    INIT,
    KEEP_ALIVE,
    MAX_BATCH,
    MESSAGE_ID,
    OPEN,
    Role,
)

if TYPE_CHECKING:
    from goalwire.zenoh.protocol.network import QueryMessage, ReplyError

KEEP_ALIVES = 4
"""How many times within its lease a silent link says that it lives."""
MOST_KEPT = 5
"""How many times the size of a message in pieces may be kept until it is whole."""
_PRIORITY = PRIORITY_EXTENSION & EXTENSION


LENGTH_SIZE = 2
"""Bytes before each batch that tell its length."""


def _missing(begun: bytes, most: int) -> int:
    """Return how many bytes a batch lacks that has begun; 0 where that is unknown, or more than `most`."""
    if len(begun) < LENGTH_SIZE:
        return 0
    missing = LENGTH_SIZE + (begun[0] | begun[1] << 8) - len(begun)
    return missing if missing <= most else 0


class ClosedByPeerError(RemoteError):
    """The other side said CLOSE: the link ends, and no program sees this."""


class Receivers(NamedTuple):
    """The receivers of what a link puts on one of its keys."""

    key: str
    callbacks: tuple[Callable[[Sample], None], ...]


class LinkOwner(Protocol):
    """A session, as far as a link needs it."""

    pieces: PieceBudget
    """How much unfinished messages may take, of all links."""

    def refuse(self, kind: str, reason: object) -> None:
        """Count something that came and is ignored."""

    def link_is_up(self, link: Link) -> None:
        """The handshake is done."""

    def receivers(self, link: Link, scope: int, suffix: bytes, is_senders: int) -> Receivers:
        """Return the receivers of a key of this link's; remembered in `link.push_receivers`."""

    def callback_failed(self, error: Exception) -> None:
        """A user's function raised."""

    def is_forged(self, link: Link, source: bytes) -> bool:
        """Whether what came over a link names a publisher that has a link of its own."""

    def query_came(
        self, link: Link, request: int, where: tuple[int, bytes, int], qos: int, query: QueryMessage
    ) -> None:
        """A REQUEST came for the key that `where` names: scope, suffix, whose."""

    def reply_key(self, link: Link, request: int, scope: int, suffix: bytes, is_senders: int) -> str | None:
        """Return the key that a RESPONSE names; None where nobody waits for it."""

    def reply_came(self, link: Link, request: int, answer: Sample | ReplyError) -> None:
        """A RESPONSE came."""

    def last_word(self, who: Link, request: int) -> None:
        """A RESPONSE_FINAL came."""

    def declaration_came(self, link: Link, declaration: Declaration) -> None:
        """A DECLARE came."""

    def interest_came(self, link: Link, interest: Interest) -> None:
        """An INTEREST came."""

    def nodes_came(self, link: Link, nodes: list[Node]) -> None:
        """An OAM told of nodes."""


class Link(Outgoing):
    """One link: what the other side has, and what comes from it; what goes there is `Outgoing`'s."""

    def __init__(
        self,
        owner: LinkOwner,
        handshake: Handshake,
        *,
        write: Callable[[Buffer], int],
        write_many: Callable[[list[Buffer]], int],
        when_full: Callable[[], None],
        wait_for_room: Callable[[bool], None],
        when_held: Callable[[Outgoing], None] | None = None,
        lease_ms: int = 60_000,
    ) -> None:
        """The functions are for `Outgoing`; `lease_ms` is this side's own lease."""
        super().__init__(write, write_many, when_full, wait_for_room, when_held)
        self.owner = owner
        self.handshake = handshake
        self.terms: Terms | None = None
        self.zid = b''
        self.role = Role.PEER
        self._own_source = b''
        """How the sources of what the other side publishes begin; empty if it is a router."""
        # what the other side has
        self.expressions: dict[int, str] = {}
        self.expression_ids: dict[str, int] = {}
        self.subscribers: KeyIndex[None] = KeyIndex()
        self.queryables: KeyIndex[tuple[bool, int]] = KeyIndex()
        self.tokens: dict[int, str] = {}
        self.interests: dict[int, Interest] = {}
        self.declared = 0
        """Bytes of what it has declared, as `bounds.DECLARED_LIMIT` counts them."""
        self.told: set[int] = set()
        """Which of the session's expression ids the other side knows."""
        self.told_of: set[int] = set()
        """Which of the session's entities a client, which asks, was told of."""
        self.knows_all = False
        """Whether all that the other side has was told here; until then it gets everything."""
        self.link_states = LinkStates()
        # the receivers of each key, looked up once
        self.push_receivers: dict[object, Receivers] = {}
        self.push_forms: dict[bytes, PushForm] = {}
        self.request_forms: dict[bytes, RequestForm] = {}
        self.reply_forms: dict[bytes, ReplyForm] = {}
        # time
        self.keep_alive_s = lease_ms / 1000 / KEEP_ALIVES
        self.heard = True
        self._silent_since: float | None = None
        # receiving
        self.reads = 0
        """Counts what `receive` has taken."""
        self.is_lost = False
        """Whether the session has let go of it."""
        self._largest_batch = MAX_BATCH
        self._tail = b''
        self._numbers = ReceivedNumbers(0)
        self._mask = MASK
        """The bits of a sequence number."""
        self._expected = b'none'
        self._reassembly: dict[int, Reassembly] = {}
        self._pieces = PieceBudget(bounds.MESSAGE_LIMIT, owner.pieces)
        self.in_pieces = False
        """Whether of a message in pieces more are to come."""

    # ---- sending

    def start(self) -> None:
        """Say what a connector says first."""
        first = self.handshake.start()
        if first:
            self.send_transport(first)

    # ---- time

    def check_lease(self, now: float) -> None:
        """See whether the other side lives; `now` in s. Raises ZenohProtocolError where its lease is over."""
        if self.heard or self._silent_since is None:
            self.heard = False
            self._silent_since = now
        elif self.terms is not None and now - self._silent_since >= self.terms.lease_ms / 1000:
            raise ZenohProtocolError(
                f'nothing was heard for its lease of {self.terms.lease_ms / 1000:g} s', EXPIRED
            )
        if self.overflowed:
            raise ZenohProtocolError(f'more than {QUEUE_END >> 20} MiB wait to be sent', UNRESPONSIVE)

    def discard_stale(self, now: float) -> int:
        """Let go of unfinished messages of which nothing has come for long; return their bytes."""
        freed = 0
        for each in list(self._reassembly.values()):
            size = each.size
            if each.is_stale(now):
                freed += size
                self.owner.refuse('message in pieces', f'its rest did not come within {bounds.STALE_S:g} s')
        return freed

    def discard_pieces(self) -> int:
        """Let go of all unfinished messages; return their bytes."""
        freed = self._pieces.used
        for each in list(self._reassembly.values()):
            each.clear()
        return freed

    # ---- receiving

    def receive(self, data: bytes) -> None:
        """Take bytes. Raises ZenohProtocolError or ClosedByPeerError, after which the link is no more."""
        self.heard = True
        start, tail = 0, self._tail
        if tail:
            if self.in_pieces:
                start = _missing(tail, len(data))
            if not start:
                data = tail + data
        end = len(data)
        try:
            if start:  # hot path: of a large message one batch in four is copied here, not all that has come
                self._take_batch(tail + data[:start])
            while end - start > 1:
                at = start + 2
                start = at + (data[at - 2] | data[at - 1] << 8)
                if start > end:
                    start = at - 2
                    break
                if data.startswith(self._expected, at):  # the next frame of reliable data
                    last, mask = self._numbers.last, self._mask
                    number = last[DATA_CHANNEL] = (last[DATA_CHANNEL] + 1) & mask
                    number = (number + 1) & mask
                    self._expected = b'%%%b%b' % (PADDED_LOW[number & 0x3FFF], PADDED_HIGH[number >> 14])
                    at = self._take_network(data, at + 5, start)
                while at < start:
                    at = self._take_transport(data, at, start)
        except IndexError:
            raise ZenohProtocolError('a message is cut off') from None
        except UnicodeDecodeError as error:
            raise ZenohProtocolError(f'a text is no UTF-8: {error}') from None
        finally:
            # Also where a signal's handler raises in the midst of it: then only the rest of a batch is lost.
            self._tail = data[start:] if start < end else b''
            self.reads += 1

    def _take_batch(self, batch: bytes) -> None:
        """Take a whole batch, its length included."""
        at, end = LENGTH_SIZE, len(batch)
        while at < end:
            at = self._take_transport(batch, at, end)

    def _take_transport(self, data: bytes, at: int, end: int) -> int:
        """Take a message of the link itself; return where it ends."""
        header = data[at]
        kind = header & MESSAGE_ID
        if end - at > self._largest_batch:
            raise ZenohProtocolError(f'a batch of {end - at} bytes exceeds what was agreed')
        if kind in (FRAME, FRAGMENT) and self.is_up:
            return self._take_numbered(data, at, end)
        reader = Reader(data, at, end)
        if kind in (INIT, OPEN):
            self._take_handshake(reader)
        elif kind == CLOSE:
            reader.u8()
            raise ClosedByPeerError(f'the other side closed the link (reason {reader.u8()})')
        elif kind == KEEP_ALIVE and self.is_up:
            reader.u8()
            if header & MORE:
                reader.extensions()
        else:
            raise ZenohProtocolError(f'message 0x{header:02x} is not expected here')
        return reader.at

    def _take_handshake(self, reader: Reader) -> None:
        handshake = self.handshake
        answer = handshake.receive(reader)
        terms = handshake.terms
        if terms is not None:
            self.terms = terms
            self.zid, self.role = terms.zid, terms.role
            if terms.role is not Role.ROUTER:
                self._own_source = encode_session(terms.zid)
            self._mask = terms.number_mask
            self._numbers = ReceivedNumbers(terms.first_received, terms.number_mask)
            self._expected = b'%%%b' % encode_padded(terms.first_received)
            self._largest_batch = terms.batch_size - 2
            self.agree(terms)
        if answer:
            self.send_transport(answer)
        if terms is not None:
            self.is_up = True
            self.owner.link_is_up(self)

    def _take_numbered(self, data: bytes, at: int, end: int) -> int:
        """Take a frame or a piece; return where it ends."""
        header = data[at]
        reader = Reader(data, at + 1, end)
        number = reader.z()
        priority, found = DATA_PRIORITY, {}
        if header & MORE:
            found = reader.extensions({_PRIORITY, IS_FIRST, IS_GIVEN_UP})
            named = found.get(_PRIORITY, DATA_PRIORITY)
            assert isinstance(named, int)
            if named >= PRIORITIES or (_PRIORITY in found and not self._has_priorities):
                raise ZenohProtocolError(f'priority {named} on a link that has it not')
            priority = named
        channel = 2 * priority + bool(header & IS_RELIABLE)
        gap = self._numbers.advance(channel, number)
        if not gap:
            return end  # it came before
        if channel == DATA_CHANNEL:
            self._expected = b'%%%b' % encode_padded((number + 1) & self._mask)
        if header & MESSAGE_ID == FRAME:
            if channel in self._reassembly:
                self._reassembly[channel].clear()
            return self._take_network(data, reader.at, end)
        reassembly = self._reassembly.get(channel)
        if reassembly is None:
            reassembly = Reassembly(has_marks=self._marks_first, budget=self._pieces)
            self._reassembly[channel] = reassembly
        start = reader.at
        # hot path: most pieces of 1 MB are not copied here, which saves 0.1 ms. What is shown of `data` keeps
        # all of it, so only what is a good part of it.
        is_shown = (end - start) * MOST_KEPT >= len(data)
        self.in_pieces = bool(header & MORE_PIECES)
        message = reassembly.add(
            memoryview(data)[start:end] if is_shown else data[start:end],
            gap=gap,
            first=IS_FIRST in found,
            more=self.in_pieces,
            given_up=IS_GIVEN_UP in found,
        )
        if message is not None:
            if message[0] & MESSAGE_ID >= FIRST_NETWORK_ID:
                self._take_network(message, 0, len(message))
        elif reassembly.is_refused:
            self.owner.refuse('message in pieces', 'unfinished messages take too much memory')
        return end

    def _take_network(self, data: bytes, at: int, end: int) -> int:
        """Take network messages until the batch ends or a message of the link begins; return where."""
        while at < end:
            header = data[at]
            kind = header & MESSAGE_ID
            if kind == PUSH:
                form = self.push_forms.get(data[at : at + KEY_SIZE])
                if form is not None and data.startswith(form.head, at):
                    at = self._take_alike(data, at, end, form)
                else:
                    at = self._take_push(data, at, end)
            elif kind == RESPONSE:
                at = self._take_response(data, at, end)
            elif kind == RESPONSE_FINAL:
                request, at = read_request_id(data, at + 1)
                if header & MORE:
                    if data[at] == QOS and data[at + 1] < MORE:  # hot path: as rmw_zenoh has it
                        at += 2
                    else:
                        _, at = read_extensions(data, at)
                self.owner.last_word(self, request)
            elif kind == REQUEST:
                at = self._take_request(data, at, end)
            elif kind < FIRST_NETWORK_ID:
                return at
            else:
                reader = Reader(data, at, end)
                if kind == DECLARE:
                    self.owner.declaration_came(self, read_declaration(reader))
                elif kind == INTEREST:
                    self.owner.interest_came(self, read_interest(reader))
                elif kind == OAM:
                    self.owner.nodes_came(self, self.link_states.read(reader))
                at = reader.at
            if at > end:
                raise ZenohProtocolError('a message is cut off')
        return at

    def _take_alike(self, data: bytes, at: int, end: int, form: PushForm) -> int:
        """Take all messages of one form that follow one another; return where they end.

        hot path: what a flood consists of. A message so takes 1.0 µs, not 2.4 as any other.
        """
        head, middle, middle_at, attachment_at, attachment_size, key, callbacks = form
        stamp_at, stamp_end = len(head), attachment_at - 2
        while data.startswith(middle, at + middle_at):
            start = at + attachment_at
            size_at = start + attachment_size
            size = data[size_at]
            payload_at = size_at + 1
            if size > 0x7F:
                size, payload_at = decode_z(data, size_at)
                if size >= LARGE:
                    break
            next_at = payload_at + size
            if next_at > end:
                raise ZenohProtocolError('a PUT is cut off')
            stamp = data[at + stamp_at : at + stamp_end]
            sample = new_sample((key, data[payload_at:next_at], data[start:size_at], stamp, None))
            at = next_at
            for callback in callbacks:
                try:
                    callback(sample)
                except Exception as error:
                    self.owner.callback_failed(error)
            if at == end or not data.startswith(head, at):
                return at
        return self._take_push(data, at, end)

    def _take_push(self, data: bytes, at: int, end: int) -> int:
        """Take one message of any form; return where it ends."""
        begin = at
        header = data[at]
        scope, suffix, at = read_wire_key(data, at + 1, header)
        if header & MORE:
            _, at = read_extensions(data, at)
        is_senders = header & IS_SENDERS
        where = (scope, is_senders, suffix) if suffix else scope | is_senders << 16
        receivers = self.push_receivers.get(where)
        if receivers is None:
            receivers = self.owner.receivers(self, scope, suffix, is_senders)
        body = at
        sample, at = read_body(data, at, end, receivers.key)
        source = sample.source
        if source is not None and not source.startswith(self._own_source):
            if self.owner.is_forged(self, source):
                return at
        elif not suffix and sample.attachment is not None and data[body] == PUT_OF_ROS:
            form = push_form(data[begin : body + 1], sample, receivers.callbacks)
            if form is not None and self._is_kept(form.head, self.push_forms):
                self.push_forms[form.head[:KEY_SIZE]] = form
            if self.push_receivers.get(where) is not receivers:  # forgotten meanwhile, by another thread
                self.push_forms.clear()
        for callback in receivers.callbacks:
            try:
                callback(sample)
            except Exception as error:
                self.owner.callback_failed(error)
        return at

    @staticmethod
    def _is_kept(name: bytes, kept: Sized) -> bool:
        """Whether what has this name may be remembered."""
        return len(name) <= bounds.KEPT_KEY and len(kept) < bounds.ROUTES_LIMIT

    def forget_receivers(self) -> None:
        """Who gets what is put has changed, or what a key's number means."""
        self.push_receivers.clear()
        self.push_forms.clear()

    def _take_request(self, data: bytes, at: int, end: int) -> int:
        header = data[at]
        request, start = read_request_id(data, at + 1)
        form = self.request_forms.get(data[start : start + KEY_SIZE])
        if form is not None and header == form.header and data.startswith(form.head, start):
            alike, at = read_alike_query(form, data, start + len(form.head), end)
            if alike is not None:
                self.owner.query_came(self, request, form.where, form.qos, alike)
                return at
        scope, suffix, at = read_wire_key(data, start, header)
        qos = 5
        if header & MORE:
            qos, at = read_extensions(data, at)
        query, at = read_query(data, at, end)
        where = (scope, suffix, header & IS_SENDERS)
        if not suffix and len(self.request_forms) < bounds.ROUTES_LIMIT:
            form = request_form(data, header, start, at, where, qos, query)
            if form is not None and self._is_kept(form.head, self.request_forms):
                self.request_forms[data[start : start + KEY_SIZE]] = form
        self.owner.query_came(self, request, where, qos, query)
        return at

    def _take_response(self, data: bytes, at: int, end: int) -> int:
        header = data[at]
        request, at = read_request_id(data, at + 1)
        scope, suffix, at = read_wire_key(data, at, header)
        form = None if scope else self.reply_forms.get(suffix)
        if form is not None and header == form.header and data.startswith(form.head, at):
            alike, next_at = read_alike_reply(form, data, at + len(form.head), end)
            if alike is not None:
                self.owner.reply_came(self, request, alike)
                return next_at
        start = at
        if header & MORE:
            _, at = read_extensions(data, at)
        key = self.owner.reply_key(self, request, scope, suffix, header & IS_SENDERS)
        answer, at = read_reply(data, at, end, key or '')
        source = answer.source if type(answer) is Sample else None
        is_own = source is None or source.startswith(self._own_source)
        if not is_own and self.owner.is_forged(self, source or b''):
            return at
        if key is not None:
            if not scope and type(answer) is Sample and self._is_kept(suffix, self.reply_forms):
                form = reply_form(data, header, start, at, answer)
                if form is not None and self._is_kept(form.head, self.reply_forms):
                    self.reply_forms[suffix] = form
            self.owner.reply_came(self, request, answer)
        return at

    def key_of(self, scope: int, suffix: bytes | str, own: dict[int, str], is_senders: int) -> str | None:
        """Return the key that the other side names, `own` being our ids.

        None for an id that is unknown, and for a key beyond all bounds.
        """
        if len(suffix) > bounds.KEY_LIMIT:
            self.owner.refuse('key', f'it has {len(suffix)} bytes, {bounds.KEY_LIMIT} are allowed')
            return None
        key = suffix if isinstance(suffix, str) else suffix.decode()
        if scope:
            base = (self.expressions if is_senders else own).get(scope)
            if base is None:
                return None
            key = base + key
            if len(key) > bounds.KEY_LIMIT:
                self.owner.refuse('key', f'it has {len(key)} characters, {bounds.KEY_LIMIT} are allowed')
                return None
        if '*' in key and key.count('*') > bounds.WILD_SIGNS:
            self.owner.refuse('key', f'it has {key.count("*")} asterisks, {bounds.WILD_SIGNS} are allowed')
            return None
        return key

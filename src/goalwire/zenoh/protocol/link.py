"""One link to another session: the other side's declarations, and the network messages that come from it.

`frames` takes the bytes that come and cuts messages out of them; `outgoing` sends. This module does the rest:
the handshake, the leases, and handing each network message to the session. A link is dead if nothing has come
for the other side's lease. A link that has sent nothing for a quarter of its own lease sends KEEP_ALIVE.
`goalwire.zenoh.io.socket_link` reads the socket, and sees that the other side has hung up.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sized
from typing import TYPE_CHECKING, NamedTuple, Protocol

from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.bodies import (
    LARGE,
    PUT_OF_ROS,
    Sample,
    new_sample,
    read_body,
    read_query,
)
from goalwire.zenoh.protocol.channels import PieceBudget
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
from goalwire.zenoh.protocol.frames import FrameReader
from goalwire.zenoh.protocol.guard import Act, Guard
from goalwire.zenoh.protocol.handshake import Handshake, Terms
from goalwire.zenoh.protocol.link_messages import FIRST_NETWORK_ID, MESSAGE_ID, Role
from goalwire.zenoh.protocol.link_state import LinkStates, Node
from goalwire.zenoh.protocol.network import (
    DECLARE,
    DEFAULT_QOS,
    INTEREST,
    IS_SENDERS,
    OAM,
    PUSH,
    QOS,
    REQUEST,
    RESPONSE,
    RESPONSE_FINAL,
    read_extensions,
    read_reply,
    read_request_id,
    read_wire_key,
    response_final,
)
from goalwire.zenoh.protocol.outgoing import QUEUE_END, Connection, Outgoing
from goalwire.zenoh.protocol.payloads import SharedPayloads
from goalwire.zenoh.protocol.peer_entities import PeerEntities
from goalwire.zenoh.protocol.pending_queries import PendingQueries
from goalwire.zenoh.protocol.primitives import (
    EXPIRED,
    MORE,
    UNRESPONSIVE,
    Reader,
    ZenohProtocolError,
    decode_z,
    encode_session,
    show_id,
)

if TYPE_CHECKING:
    from goalwire.zenoh.protocol.bodies import QueryMessage

KEEP_ALIVES = 4
"""How many times within its lease an idle link sends KEEP_ALIVE."""


class Receivers(NamedTuple):
    """The receivers of the messages that the other side of a link publishes on one key."""

    key: str
    callbacks: tuple[Callable[[Sample], None], ...]
    take_views: bool = False
    """True if a receiver takes payloads in shared memory as views."""


class Router(Protocol):
    """The part of a session that knows the receivers of each message and query."""

    def receivers(self, link: Link, scope: int, suffix: bytes, is_senders: int) -> Receivers:
        """Return the receivers of a key that this link declared. It may call `Link.remember_receivers`."""

    def is_forged(self, link: Link, source: bytes) -> bool:
        """Return whether a message names a publisher with a link of its own, but came over another link."""

    def take_query(
        self, link: Link, request: int, where: tuple[int, bytes, int], qos: int, query: QueryMessage
    ) -> None:
        """Take a REQUEST. `where` is its key: the scope, the suffix, and the side that declared the scope."""


class LinkOwner(Protocol):
    """A session, as far as a link needs it."""

    @property
    def pieces(self) -> PieceBudget:
        """The budget for the unfinished messages of all links."""

    @property
    def own_keys(self) -> Mapping[int, str]:
        """The keys that this session has numbered."""

    @property
    def queries(self) -> PendingQueries:
        """The queries that wait for answers."""

    @property
    def routes(self) -> Router:
        """The receivers of messages and queries."""

    @property
    def refuse(self) -> Callable[[str, object], object]:
        """Counts an ignored message, by its kind and the reason."""

    @property
    def report(self) -> Callable[[Exception], None]:
        """Log what a user's function raised."""

    def take_link(self, link: Link) -> None:
        """Take a link whose handshake is done."""

    def take_declaration(self, link: Link, declaration: Declaration) -> None:
        """Take a DECLARE."""

    def take_interest(self, link: Link, wish: Interest) -> None:
        """Take an INTEREST."""

    def take_nodes(self, link: Link, nodes: list[Node]) -> None:
        """Take an OAM, which announces nodes."""


class Link:
    """One link: reads what comes from the other side and hands it to the session."""

    def __init__(
        self, owner: LinkOwner, handshake: Handshake, connection: Connection, *, lease_ms: int = 60_000
    ) -> None:
        """`connection` writes the bytes of this link; `lease_ms` is this side's own lease."""
        self.handshake = handshake
        self.terms: Terms | None = None
        self.zid = b''
        self.role = Role.PEER
        self.is_up = False
        """True from the end of the handshake until the link is closed."""
        self.is_lost = False
        """True once the session has forgotten this link."""
        self.guard: Guard | None = None
        """The other side's permissions, if links have certificates; None allows everything."""
        self.outgoing = Outgoing(connection)
        self.frames = FrameReader(owner.pieces, self._take_handshake, self._take_network, owner.refuse)
        self.peer = PeerEntities(owner.own_keys, owner.refuse)
        self.keep_alive_s = lease_ms / 1000 / KEEP_ALIVES
        self.push_receivers: dict[object, Receivers] = {}
        """The receivers of each key, as far as they were looked up."""
        self.push_forms: dict[bytes, PushForm] = {}
        self.request_forms: dict[bytes, RequestForm] = {}
        self.reply_forms: dict[bytes, ReplyForm] = {}
        self._owner = owner
        self._queries = owner.queries
        self._routes = owner.routes
        self._report = owner.report
        self._link_states = LinkStates()
        self._shared = SharedPayloads(owner.refuse)
        self._own_source = b''
        """The first bytes of the source ids of the other side's own publishers; empty for a router."""
        self._silent_since: float | None = None

    def refusal(self, act: Act, key: str) -> str:
        """Return why the other side may not do `act` on `key`; '' if it may."""
        guard = self.guard
        if guard is None:
            return ''
        if self.role is Role.ROUTER and not guard.forwards:
            return 'it is only here to tell peers of each other'
        return guard.refusal(act, key, show_id(self.zid))

    def start(self) -> None:
        """Send the connector's first message."""
        first = self.handshake.start()
        if first:
            self.outgoing.send_transport(first)

    def _take_handshake(self, reader: Reader) -> None:
        """Take a message of the handshake and answer it. After the last message the link is up."""
        answer = self.handshake.receive(reader)
        terms = self.handshake.terms
        if terms is not None:
            self.terms = terms
            self.zid = self.peer.zid = terms.zid
            self.role = terms.role
            if terms.role is not Role.ROUTER:
                self._own_source = encode_session(terms.zid)
            # The terms apply before the answer goes out, since the other side may then send frames at once.
            self.frames.agree(terms)
            self.outgoing.agree(terms)
            self._shared.agree(self.handshake, self.outgoing)
        if answer:
            self.outgoing.send_transport(answer)
        if terms is not None:
            self.is_up = True
            self._owner.take_link(self)

    def close(self, reason: int | None = None) -> None:
        """Stop sending and ignore further messages; with a `reason`, send CLOSE first."""
        self.outgoing.close(reason)
        self.frames.close()
        self.handshake.close()
        self.is_up = False

    # ---- whether the other side lives and reads

    def check_lease(self, now: float) -> None:
        """Raise ZenohProtocolError if nothing has come for the other side's lease; `now` in s."""
        if self.frames.has_heard() or self._silent_since is None:
            self._silent_since = now
        elif self.terms is not None and now - self._silent_since >= self.terms.lease_ms / 1000:
            raise ZenohProtocolError(
                f'nothing was heard for its lease of {self.terms.lease_ms / 1000:g} s', EXPIRED
            )
        if self.outgoing.overflowed:
            raise ZenohProtocolError(f'more than {QUEUE_END >> 20} MiB wait to be sent', UNRESPONSIVE)

    def check_reads(self) -> None:
        """Raise ZenohProtocolError if the other side sends more queries without reading the answers."""
        if self.outgoing.queue.size > bounds.UNREAD_LIMIT:
            raise ZenohProtocolError(
                f'the other side leaves over {bounds.UNREAD_LIMIT >> 20} MiB of answers unread', UNRESPONSIVE
            )

    # ---- network messages

    def _take_network(self, data: bytes, at: int, end: int) -> int:
        """Take network messages up to `end` or to a message of the link itself; return their end."""
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
                    # hot path: rmw_zenoh sends one extension only, QOS
                    if data[at] == QOS and data[at + 1] < MORE:
                        at += 2
                    else:
                        _, at = read_extensions(data, at)
                self._queries.take_final(self, request)
            elif kind == REQUEST:
                at = self._take_request(data, at, end)
            elif kind < FIRST_NETWORK_ID:
                return at
            else:
                reader = Reader(data, at, end)
                if kind == DECLARE:
                    self._owner.take_declaration(self, read_declaration(reader))
                elif kind == INTEREST:
                    self._owner.take_interest(self, read_interest(reader))
                elif kind == OAM:
                    self._owner.take_nodes(self, self._link_states.read(reader))
                at = reader.at
            if at > end:  # the functions above do not check the lengths in a message
                raise ZenohProtocolError('a message is cut off')
        return at

    def _take_alike(self, data: bytes, at: int, end: int, form: PushForm) -> int:
        """Take all consecutive messages of one form; return their end.

        hot path: a flood consists of such messages. One takes 1.0 µs here, and 2.4 in `_take_push`.
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
                    self._report(error)
            if at == end or not data.startswith(head, at):
                return at
        return self._take_push(data, at, end)

    def _take_push(self, data: bytes, at: int, end: int) -> int:
        """Take one message of any form; return its end."""
        begin, header, qos = at, data[at], DEFAULT_QOS
        scope, suffix, at = read_wire_key(data, at + 1, header)
        if header & MORE:
            qos, at = read_extensions(data, at)
        is_senders = header & IS_SENDERS
        # Most messages name their key by a number: receivers are kept by that number and its declaring side.
        where = (scope, is_senders, suffix) if suffix else scope | is_senders << 16
        receivers = self.push_receivers.get(where)
        if receivers is None:
            receivers = self._routes.receivers(self, scope, suffix, is_senders)
        body = at
        fetch = self._shared.of(qos, as_view=receivers.take_views)
        sample, at = read_body(data, at, end, receivers.key, fetch)
        if sample is None:
            return at
        source = sample.source
        # Most messages name the other side itself as their source, as the first bytes of the source show.
        if source is not None and not source.startswith(self._own_source):
            if self._routes.is_forged(self, source):
                return at
        elif not suffix and sample.attachment is not None and data[body] == PUT_OF_ROS:
            form = push_form(data[begin : body + 1], sample, receivers.callbacks)
            if form is not None and self._is_kept(form.head, self.push_forms):
                self.push_forms[form.head[:KEY_SIZE]] = form
            # If another thread has changed the receivers meanwhile, the form is outdated, too.
            if self.push_receivers.get(where) is not receivers:
                self.push_forms.clear()
        for callback in receivers.callbacks:
            try:
                callback(sample)
            except Exception as error:
                self._report(error)
        return at

    @staticmethod
    def _is_kept(name: bytes, kept: Sized) -> bool:
        """Return whether there is room to remember an entry under this name."""
        return len(name) <= bounds.KEPT_KEY and len(kept) < bounds.ROUTES_LIMIT

    def remember_receivers(self, scope: int, suffix: bytes, is_senders: int, receivers: Receivers) -> None:
        """Keep the receivers of a key for the next messages on it. The caller holds the session's section."""
        if len(suffix) > bounds.KEPT_KEY:
            return
        where = (scope, is_senders, suffix) if suffix else scope | is_senders << 16
        if len(self.push_receivers) >= bounds.ROUTES_LIMIT:
            self.forget_receivers()
        self.push_receivers[where] = receivers

    def forget_receivers(self) -> None:
        """Forget all receivers: they have changed, or a number now stands for another key."""
        self.push_receivers.clear()
        self.push_forms.clear()

    def _take_request(self, data: bytes, at: int, end: int) -> int:
        """Take a query of the other side; return the position after it in `data`.

        The requests of one querier differ little. So the first one is kept as a form, and of each later one
        only the differences are read.
        """
        header = data[at]
        request, start = read_request_id(data, at + 1)
        form = self.request_forms.get(data[start : start + KEY_SIZE])
        if form is not None and header == form.header and data.startswith(form.head, start):
            alike, at = read_alike_query(form, data, start + len(form.head), end)
            if alike is not None:
                self._routes.take_query(self, request, form.where, form.qos, alike)
                return at
        scope, suffix, at = read_wire_key(data, start, header)
        qos = 5
        if header & MORE:
            qos, at = read_extensions(data, at)
        query, at = read_query(data, at, end, self._shared.of(qos))
        if query is None:
            # The query is lost. The final saves the asking side from waiting for its timeout.
            self.outgoing.send(2 * (qos & 7) + 1, response_final(request, qos))
            return at
        where = (scope, suffix, header & IS_SENDERS)
        if not suffix and len(self.request_forms) < bounds.ROUTES_LIMIT:
            form = request_form(data, header, start, at, where, qos, query)
            if form is not None and self._is_kept(form.head, self.request_forms):
                self.request_forms[data[start : start + KEY_SIZE]] = form
        self._routes.take_query(self, request, where, qos, query)
        return at

    def _take_response(self, data: bytes, at: int, end: int) -> int:
        """Take an answer to a query of this session; return its end.

        The replies on one key differ little, so all but the first are read by a form.
        """
        header = data[at]
        request, at = read_request_id(data, at + 1)
        scope, suffix, at = read_wire_key(data, at, header)
        form = None if scope else self.reply_forms.get(suffix)
        if form is not None and header == form.header and data.startswith(form.head, at):
            alike, next_at = read_alike_reply(form, data, at + len(form.head), end)
            if alike is not None:
                self._queries.take_reply(self, request, alike)
                return next_at
        start, qos = at, DEFAULT_QOS
        if header & MORE:
            qos, at = read_extensions(data, at)
        # The reply is read even if no query waits for it: the next message begins at its end.
        key = self._reply_key(request, scope, suffix, header & IS_SENDERS)
        answer, at = read_reply(data, at, end, key or '', self._shared.of(qos))
        if answer is None:
            return at
        source = answer.source if type(answer) is Sample else None
        is_own = source is None or source.startswith(self._own_source)
        if not is_own and self._routes.is_forged(self, source or b''):
            return at
        if key is not None and type(answer) is Sample and self.refusal(Act.REPLY, key):
            return at
        if key is not None:
            if not scope and type(answer) is Sample and self._is_kept(suffix, self.reply_forms):
                form = reply_form(data, header, start, at, answer)
                if form is not None and self._is_kept(form.head, self.reply_forms):
                    self.reply_forms[suffix] = form
            self._queries.take_reply(self, request, answer)
        return at

    def _reply_key(self, request: int, scope: int, suffix: bytes, is_senders: int) -> str | None:
        """Return the key of a reply, usually its query's key; None if no query waits for the reply."""
        query = self._queries.find(self, request)
        if query is None:
            return None
        if not scope and suffix == query.encoded_key:
            return query.key
        return self.peer.key_of(scope, suffix, is_senders)

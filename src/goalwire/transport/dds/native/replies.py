"""The reader that takes the replies of one service for all of a session's clients.

If each client had a reader, a server would send each reply to all of them, and each would acknowledge it. So
the clients of one service, type and QoS share a reader, and a table tells which client a reply is for. Each
client counts its requests from 1, so its requests need a GUID of their own to name. The first client uses the
GUID of the shared reader. Any other client announces a reader that receives nothing, and uses its GUID.

ROS 2 counts the clients of a service by their readers of replies (rmw_count_clients in rmw_fastrtps and
rmw_cyclonedds), so its count is right. If the first client closes before the others, the count is one too
high until all have closed: no other client gets the first one's GUID, since replies to it may still arrive.
"""

from __future__ import annotations

from collections.abc import Hashable
from functools import partial
from itertools import count
from typing import Protocol

from goalwire.errors import RemoteError
from goalwire.rtps.protocol.announcements import EndpointData as RtpsEndpoint
from goalwire.rtps.protocol.qos import Qos
from goalwire.rtps.protocol.reader import ReaderListener
from goalwire.rtps.protocol.reader import Sample as RtpsSample
from goalwire.transport.contract import Endpoint
from goalwire.transport.dds.description import EndpointData, Role
from goalwire.transport.dds.native.context import NativeContext
from goalwire.transport.dds.native.dialects import Reply, read_reply
from goalwire.transport.dds.native.qos import service_qos
from goalwire.transport.dds.native.service_ends import names_of, side_of, user_data
from goalwire.transport.endpoint import EndpointState

SILENCE_S = 0.25
"""A server's writer that was matched this long ago counts as knowing the client, even if it has sent nothing.
RustDDS is silent until it writes; Fast DDS and Cyclone DDS announce within 0.1 s that they have no
samples."""


class ReplyTaker(Protocol):
    """A client that shares a reply reader with others."""

    state: EndpointState

    def take_reply(self, reply: Reply, time: int | None) -> None:
        """Take a reply to a request of this client; `time` is when the reply was written."""

    def look(self) -> None:
        """Find out again whether a server can be called, and its reply can arrive."""

    def lose_writer(self, side: str) -> None:
        """Note that a server's writer has gone, given by its `side_of`."""


class ReplyReader(ReaderListener):
    """Reads the replies of one service, and gives each to the client whose request it answers."""

    def __init__(self, context: NativeContext, endpoint: Endpoint) -> None:
        self.client_id = context.next_service_id()
        """The id in the USER_DATA of all clients that share this reader. A server on Cyclone DDS looks for a
        reader with that id."""
        self.users = 1
        """How many clients use this reader, or are about to. Changed inside `Wire.run`."""
        self._context = context
        self._clients: dict[ReplyTaker, None] = {}
        self._by_name: dict[bytes | int, ReplyTaker] = {}
        """The clients by the GUIDs and numbers with which replies name them."""
        self._next_name = count().__next__
        data = EndpointData(endpoint.type_hash, client_id=self.client_id, takes_refusals=True)
        self._names = names_of(Role.REPLY, endpoint)
        self._told = user_data(Role.REPLY, endpoint, data)
        self.reader = context.participant.create_reader(
            *self._names, service_qos(endpoint.qos), self, self._told
        )

    def make_name(self) -> bytes:
        """Return a GUID that a new client's requests can name, until `drop_name`."""
        if self._next_name() == 0:
            return self.reader.data.guid
        return self._context.participant.announce_reader(*self._names, Qos(), self._told).guid

    def drop_name(self, name: bytes) -> None:
        """Withdraw the GUID of a client that has gone."""
        if name != self.reader.data.guid:
            self._context.participant.withdraw_reader(name)

    def add(self, client: ReplyTaker, names: tuple[bytes | int, ...]) -> None:
        """Give a client the replies that name it by one of `names`."""
        self._clients[client] = None
        for name in names:
            self._by_name[name] = client

    def remove(self, client: ReplyTaker, names: tuple[bytes | int, ...]) -> None:
        """Give a client no more replies."""
        self._clients.pop(client, None)
        for name in names:
            self._by_name.pop(name, None)

    def on_sample(self, sample: RtpsSample) -> None:
        """Give a reply to its client; ignore replies to the clients of other sessions."""
        if sample.payload is None:
            return
        try:
            reply = read_reply(sample.qos, sample.payload)
        except RemoteError as error:
            client = next(iter(self._clients.copy()), None)
            self._context.rejects.add('reply', error, None if client is None else client.state)
            return
        client = None if reply is None else self._by_name.get(reply.client)
        if reply is not None and client is not None:
            client.take_reply(reply, sample.time)

    # ---- servers that come and go

    def answering(self) -> set[str]:
        """Return the servers, as `side_of` names them, whose writers know this reader."""
        long_ago = self._context.participant.clock() - SILENCE_S
        return {
            side_of(proxy.data)
            for proxy in list(self.reader.writers.values())
            if proxy.next or not proxy.is_reliable or proxy.matched_at <= long_ago
        }

    def writing(self) -> set[str]:
        """Return the servers, as `side_of` names them, whose writers are matched with this reader."""
        return {side_of(proxy.data) for proxy in list(self.reader.writers.values())}

    def _look(self) -> None:
        for client in self._clients.copy():
            client.look()
        self._context.notifier.connected()

    def on_matched(self, writer: RtpsEndpoint) -> None:  # noqa: ARG002
        self._context.call_later(2 * SILENCE_S, self._look)

    def on_answered(self, writer: RtpsEndpoint) -> None:  # noqa: ARG002
        self._look()

    def on_unmatched(self, writer: RtpsEndpoint) -> None:
        self._look()
        side = side_of(writer)
        for client in self._clients.copy():
            client.lose_writer(side)


class ReplyReaders:
    """The reply readers of one session."""

    def __init__(self, context: NativeContext) -> None:
        self._context = context
        self._readers: dict[Hashable, ReplyReader] = {}

    def take(self, endpoint: Endpoint) -> ReplyReader:
        """Return the reader for a new client, which calls `give_back` when it closes."""
        key = names_of(Role.REPLY, endpoint), service_qos(endpoint.qos), endpoint.type_hash
        run = self._context.participant.run
        wanted: list[Hashable] = [key]
        found = run(partial(self._find, wanted), None)
        wanted.clear()
        if found is not None:
            return found
        made = ReplyReader(self._context, endpoint)
        # If another thread has added a reader meanwhile, this new reader serves only the new client.
        run(partial(self._readers.setdefault, key, made), made)
        return made

    def _find(self, wanted: list[Hashable]) -> ReplyReader | None:
        if not wanted:
            return None  # a signal handler called `take`, which returned before this postponed call
        found = self._readers.get(wanted[0])
        if found is not None:
            found.users += 1
        return found

    def give_back(self, shared: ReplyReader) -> None:
        """Note that a client has closed; delete the reader after the last one."""
        self._context.participant.run(partial(self._leave, shared), None)

    def _leave(self, shared: ReplyReader) -> None:
        shared.users -= 1
        if not shared.users:
            for key in [key for key, reader in self._readers.items() if reader is shared]:
                del self._readers[key]
            self._context.participant.delete(shared.reader)

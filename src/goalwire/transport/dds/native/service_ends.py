"""The common part of clients and servers: their readers and writers, and samples that wait for room."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial

from goalwire.rtps.protocol.announcements import EndpointData as RtpsEndpoint
from goalwire.rtps.protocol.reader import Reader, ReaderListener
from goalwire.rtps.protocol.writer import Writer, WriterListener
from goalwire.transport.contract import Endpoint
from goalwire.transport.dds.description import (
    EndpointData,
    Role,
    dds_topic,
    dds_type,
    decode_endpoint,
    encode_endpoint,
)
from goalwire.transport.dds.native.context import NativeContext
from goalwire.transport.dds.native.qos import service_qos
from goalwire.transport.endpoint import EndpointState


def names_of(role: Role, endpoint: Endpoint) -> tuple[str, str]:
    """Return the DDS names of the topic and type of a service's reader or writer."""
    topic = dds_topic(role, endpoint.name, verbatim=endpoint.qos.avoid_ros_namespace_conventions)
    return topic, dds_type(role, endpoint.type_name)


def user_data(role: Role, endpoint: Endpoint, data: EndpointData) -> bytes:
    """Return the user data of a reader or writer. Its hash is that of the request or of the response."""
    if endpoint.part_hashes is not None:
        of_request, of_response = endpoint.part_hashes()
        data = data._replace(type_hash=of_request if role is Role.REQUEST else of_response)
    return encode_endpoint(data)


def make_writer(
    context: NativeContext,
    state: EndpointState,
    endpoint: Endpoint,
    data: EndpointData,
    role: Role,
    listener: WriterListener,
) -> Writer:
    """Make the writer of requests or replies, as `role` says; `state` keeps the step that deletes it."""
    participant = context.participant
    told = user_data(role, endpoint, data)
    qos = service_qos(endpoint.qos)
    writer = participant.create_writer(*names_of(role, endpoint), qos, listener, told)
    state.undo.append(partial(participant.delete, writer))
    return writer


def make_reader(
    context: NativeContext,
    state: EndpointState,
    endpoint: Endpoint,
    data: EndpointData,
    role: Role,
    listener: ReaderListener,
) -> Reader:
    """Make the reader of requests or replies, as `role` says; `state` keeps the step that deletes it."""
    participant = context.participant
    told = user_data(role, endpoint, data)
    qos = service_qos(endpoint.qos)
    reader = participant.create_reader(*names_of(role, endpoint), qos, listener, told)
    state.undo.append(partial(participant.delete, reader))
    return reader


def side_of(endpoint: RtpsEndpoint) -> str:
    """Return what the reader and writer of one client or server share: an id, else their participant."""
    told = decode_endpoint(endpoint.user_data)
    return told.service_id or told.client_id or endpoint.prefix.hex()


class WaitingSamples:
    """Samples for which a writer has no room yet, by their receiver. Used inside `Wire.run`."""

    def __init__(self) -> None:
        self.queues: dict[bytes | None, deque[Callable[[], bool]]] = {}
        """The samples that wait; those for one receiver keep their order."""

    def send(self, reader: bytes | None, send: Callable[[], bool]) -> None:
        """Call `send` now, or after earlier samples for the reader; `send` returns False without room."""
        queue = self.queues.get(reader)
        if queue is not None:
            queue.append(send)
        elif not send():
            self.queues[reader] = deque([send])

    def send_all(self) -> None:
        """Send the waiting samples, as far as there is room."""
        for reader, queue in list(self.queues.items()):
            while queue and queue[0]():
                queue.popleft()
            if not queue:
                del self.queues[reader]

    def discard(self, reader: bytes) -> None:
        """Drop the samples for a reader that has gone."""
        self.queues.pop(reader, None)

"""The two ends of a client or a server: a writer and a reader with one id."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from goalwire.records import replace
from goalwire.rules.qos import HistoryPolicy
from goalwire.transport.contract import Endpoint
from goalwire.transport.dds.context import DdsContext
from goalwire.transport.dds.names import Role, dds_topic, dds_type
from goalwire.transport.dds.qos import endpoint_qos
from goalwire.transport.dds.queueing_writer import QueueingWriter
from goalwire.transport.dds.user_data import EndpointData, encode_endpoint
from goalwire.transport.dds.wire import Reader, Writer

_DETOUR_DEPTH = 100
"""Replies that a writer keeps beside one that is held up. More, and a mute client would hold this one up too:
with 30 KB that are not acknowledged the library may have no room."""


def _user_data(role: Role, endpoint: Endpoint, data: EndpointData) -> bytes:
    """Return what an end says of itself: the hash is that of what it carries."""
    if endpoint.part_hashes is not None:
        of_request, of_response = endpoint.part_hashes()
        data = data._replace(type_hash=of_request if role is Role.REQUEST else of_response)
    return encode_endpoint(data)


def make_writer(
    context: DdsContext, role: Role, endpoint: Endpoint, data: EndpointData, undo: list[Callable[[], object]]
) -> QueueingWriter:
    """Declare the sending end. It keeps all: of a burst, ROS 2's ten drop what is not there yet.

    Only replies may take a fallback writer: a request's writer is its client, by which the graph knows it.
    """
    topic = dds_topic(role, endpoint.name, verbatim=endpoint.qos.avoid_ros_namespace_conventions)
    where = context.participant, topic, dds_type(role, endpoint.type_name)
    said = _user_data(role, endpoint, data)

    def make_detour() -> Writer:
        short = replace(endpoint.qos, history=HistoryPolicy.KEEP_LAST, depth=_DETOUR_DEPTH)
        with endpoint_qos(context.library, short, said, blocking_ns=0) as qos:
            return Writer(*where, qos)

    kept = replace(endpoint.qos, history=HistoryPolicy.KEEP_ALL)
    with endpoint_qos(context.library, kept, said, blocking_ns=0) as qos:
        if role is Role.REPLY:
            writer = QueueingWriter(*where, qos, make_detour)
        else:
            writer = QueueingWriter(*where, qos, guard=context.guard)
    undo.append(writer.delete)
    undo.append(partial(context.statuses.discard, writer.handle))
    return writer


def make_reader(
    context: DdsContext, role: Role, endpoint: Endpoint, data: EndpointData, undo: list[Callable[[], object]]
) -> Reader:
    """Declare the receiving end. It keeps all: what it drops would be a call without an answer."""
    verbatim = endpoint.qos.avoid_ros_namespace_conventions
    topic = dds_topic(role, endpoint.name, verbatim=verbatim)
    kept = replace(endpoint.qos, history=HistoryPolicy.KEEP_ALL)
    with endpoint_qos(context.library, kept, _user_data(role, endpoint, data)) as qos:
        reader = Reader(context.participant, topic, dds_type(role, endpoint.type_name), qos)
    undo.append(reader.delete)
    undo.append(partial(context.statuses.discard, reader.handle))
    return reader

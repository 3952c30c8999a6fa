"""What the wire brings, a message, a request or a reply, made into a sample."""

from __future__ import annotations

from time import time_ns

from goalwire.errors import RemoteError
from goalwire.transport.contract import Sample, new_sample
from goalwire.transport.zenoh.attachment import GID_SIZE, SIZE, decode, split
from goalwire.transport.zenoh.protocol.queries import Query
from goalwire.transport.zenoh.wire import Message


def sample_of(carrier: Message | Query) -> Sample:
    """Return what came; raises RemoteError where it breaks the rules.

    Everything that comes passes here, on a thread that has just been woken: so the ordinary attachment is
    read in place, which saves three calls.
    """
    received = time_ns()
    data, payload = carrier.attachment, carrier.payload
    if data is None:
        raise RemoteError('attachment: there is none')
    size = 0
    if len(data) == SIZE:
        sequence, sent, size, gid = split(data)
    if size != GID_SIZE or sequence < 0 or sent < 0:
        sequence, sent, gid = decode(data)
    if payload is None:
        raise RemoteError(f'request {sequence} has no payload')
    return new_sample((payload, sequence, sent, received, gid))

"""Conversion between ROS 2's QoS and libddsc's, which also holds the endpoint's user data."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import byref, c_int32, c_int64, c_size_t, c_void_p, string_at

from goalwire.rules.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoS,
    ReliabilityPolicy,
)
from goalwire.transport.dds.cyclone.abi import INFINITY, Library

_KEEP_LAST, _KEEP_ALL = 0, 1
_BEST_EFFORT, _RELIABLE = 0, 1
_VOLATILE, _TRANSIENT_LOCAL = 0, 1
_AUTOMATIC, _MANUAL_BY_TOPIC = 0, 2
_IGNORE_PARTICIPANT = 1
_UNLIMITED = -1
_LARGEST_DEPTH = 2**31 - 1

_DURABILITIES = {_VOLATILE: DurabilityPolicy.VOLATILE, _TRANSIENT_LOCAL: DurabilityPolicy.TRANSIENT_LOCAL}
_LIVELINESSES = {
    _AUTOMATIC: LivelinessPolicy.AUTOMATIC,
    _MANUAL_BY_TOPIC: LivelinessPolicy.MANUAL_BY_TOPIC,
}
_RELIABILITIES = {_BEST_EFFORT: ReliabilityPolicy.BEST_EFFORT, _RELIABLE: ReliabilityPolicy.RELIABLE}


@contextmanager
def endpoint_qos(
    library: Library,
    qos: QoS,
    user_data: bytes,
    *,
    ignore_local: bool = False,
    blocking_ns: int = INFINITY,
) -> Iterator[int]:
    """Make a dds_qos_t for one reader or writer; it lives as long as the block.

    A reliable write waits for room up to `blocking_ns`.
    """
    made = library.dds_create_qos()
    try:
        _fill(library, made, qos, blocking_ns)
        library.dds_qset_userdata(made, user_data, len(user_data))
        library.dds_qset_writer_data_lifecycle(made, False)
        if ignore_local:
            library.dds_qset_ignorelocal(made, _IGNORE_PARTICIPANT)
        yield made
    finally:
        library.dds_delete_qos(made)


def _fill(library: Library, made: int, qos: QoS, blocking_ns: int) -> None:
    keep = _KEEP_ALL if qos.keeps_all else _KEEP_LAST
    depth = _UNLIMITED if qos.keeps_all else min(qos.depth or 1, _LARGEST_DEPTH)
    library.dds_qset_history(made, keep, depth)
    if qos.is_reliable:
        library.dds_qset_reliability(made, _RELIABLE, blocking_ns)
    else:
        library.dds_qset_reliability(made, _BEST_EFFORT, 0)
    if qos.is_transient_local:
        library.dds_qset_durability(made, _TRANSIENT_LOCAL)
        limits = (_UNLIMITED, _UNLIMITED, _UNLIMITED)
        library.dds_qset_durability_service(made, 0, keep, depth, *limits)
    else:
        library.dds_qset_durability(made, _VOLATILE)
    if qos.deadline_ns:
        library.dds_qset_deadline(made, qos.deadline_ns)
    if qos.lifespan_ns:
        library.dds_qset_lifespan(made, qos.lifespan_ns)
    manual = qos.liveliness is LivelinessPolicy.MANUAL_BY_TOPIC
    library.dds_qset_liveliness(made, _MANUAL_BY_TOPIC if manual else _AUTOMATIC, qos.lease_ns or INFINITY)


def read_qos(library: Library, made: int, *, verbatim: bool = False) -> QoS:
    """Return the QoS in an endpoint's dds_qos_t; open policies are UNKNOWN, or DDS's default."""
    kind, depth, duration = c_int32(), c_int32(), c_int64()
    history, kept = HistoryPolicy.UNKNOWN, 0
    if library.dds_qget_history(made, byref(kind), byref(depth)):
        keeps_all = kind.value == _KEEP_ALL
        history = HistoryPolicy.KEEP_ALL if keeps_all else HistoryPolicy.KEEP_LAST
        kept = 0 if keeps_all else depth.value
    reliability = ReliabilityPolicy.UNKNOWN
    if library.dds_qget_reliability(made, byref(kind), byref(duration)):
        reliability = _RELIABILITIES.get(kind.value, reliability)
    durability = DurabilityPolicy.UNKNOWN
    if library.dds_qget_durability(made, byref(kind)):
        durability = _DURABILITIES.get(kind.value, durability)
    deadline = duration.value if library.dds_qget_deadline(made, byref(duration)) else INFINITY
    lifespan = duration.value if library.dds_qget_lifespan(made, byref(duration)) else INFINITY
    liveliness, lease = LivelinessPolicy.UNKNOWN, INFINITY
    if library.dds_qget_liveliness(made, byref(kind), byref(duration)):
        liveliness, lease = _LIVELINESSES.get(kind.value, liveliness), duration.value
    return QoS(kept, history, reliability, durability, deadline, lifespan, liveliness, lease, verbatim)


_PORT = re.compile(r':([0-9]+)(?=@|,|$)')


def read_ports(library: Library, made: int, host: str) -> frozenset[int] | None:
    """Return the UDP ports at which a participant listens for discovery, if it is on `host`.

    None if the participant does not announce them: an older Cyclone DDS, or another vendor's DDS.
    """
    addresses = _read_property(library, made, b'__NetworkAddresses')
    if addresses is None:
        return None
    if _read_property(library, made, b'__Hostname') != host:
        return frozenset()
    return frozenset(map(int, _PORT.findall(addresses)))


def _read_property(library: Library, made: int, name: bytes) -> str | None:
    value = c_void_p()
    if not library.dds_qget_prop(made, name, byref(value)) or not value.value:
        return None
    try:
        return string_at(value.value).decode(errors='replace')
    finally:
        library.dds_free(value)


def read_user_data(library: Library, made: int) -> bytes:
    """Return the user data in a dds_qos_t, b'' if there is none."""
    value, size = c_void_p(), c_size_t()
    if not library.dds_qget_userdata(made, byref(value), byref(size)) or not value.value:
        return b''
    try:
        return string_at(value.value, size.value)
    finally:
        library.dds_free(value)

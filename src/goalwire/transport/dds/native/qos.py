"""Converts a QoS of ROS 2 to RTPS's terms, and back."""

from __future__ import annotations

from goalwire.records import replace
from goalwire.rtps.protocol import qos as rtps
from goalwire.rtps.protocol.primitives import INFINITE
from goalwire.rules.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoS,
    ReliabilityPolicy,
)
from goalwire.transport.dds.native.rmw import RmwDefaults

_DURABILITIES = {
    rtps.VOLATILE: DurabilityPolicy.VOLATILE,
    rtps.TRANSIENT_LOCAL: DurabilityPolicy.TRANSIENT_LOCAL,
}
_LIVELINESSES = {
    rtps.AUTOMATIC: LivelinessPolicy.AUTOMATIC,
    rtps.MANUAL_BY_TOPIC: LivelinessPolicy.MANUAL_BY_TOPIC,
}
_RELIABILITIES = {
    rtps.BEST_EFFORT: ReliabilityPolicy.BEST_EFFORT,
    rtps.RELIABLE: ReliabilityPolicy.RELIABLE,
}


def writer_qos(qos: QoS, defaults: RmwDefaults) -> rtps.Qos:
    """Return the RTPS QoS that a publisher offers."""
    return replace(_common(qos, is_reliable=qos.is_reliable), max_blocking=defaults.blocking_ns)


def reader_qos(qos: QoS, defaults: RmwDefaults) -> rtps.Qos:
    """Return the RTPS QoS that a subscription requests."""
    is_told = qos.reliability is not ReliabilityPolicy.SYSTEM_DEFAULT
    return _common(qos, is_reliable=qos.is_reliable if is_told else defaults.has_reliable_readers)


def service_qos(qos: QoS) -> rtps.Qos:
    """Return the QoS of a service's readers and writers. They keep all samples, so no call is dropped."""
    return replace(_common(qos, is_reliable=qos.is_reliable), depth=0)


def _common(qos: QoS, *, is_reliable: bool) -> rtps.Qos:
    manual = qos.liveliness is LivelinessPolicy.MANUAL_BY_TOPIC
    return rtps.Qos(
        reliability=rtps.RELIABLE if is_reliable else rtps.BEST_EFFORT,
        durability=rtps.TRANSIENT_LOCAL if qos.is_transient_local else rtps.VOLATILE,
        depth=0 if qos.keeps_all else qos.depth or 1,
        deadline=qos.deadline_ns or INFINITE,
        lifespan=qos.lifespan_ns or INFINITE,
        liveliness=rtps.MANUAL_BY_TOPIC if manual else rtps.AUTOMATIC,
        lease=qos.lease_ns or INFINITE,
    )


def ros_qos(told: rtps.Qos, *, verbatim: bool) -> QoS:
    """Return the QoS that an endpoint announces; policies that it does not announce are UNKNOWN."""
    if told.depth == rtps.UNTOLD:
        history, depth = HistoryPolicy.UNKNOWN, 0
    else:
        history = HistoryPolicy.KEEP_LAST if told.depth else HistoryPolicy.KEEP_ALL
        depth = told.depth
    return QoS(
        depth,
        history,
        _RELIABILITIES.get(told.reliability, ReliabilityPolicy.UNKNOWN),
        _DURABILITIES.get(told.durability, DurabilityPolicy.UNKNOWN),
        told.deadline,
        told.lifespan,
        _LIVELINESSES.get(told.liveliness, LivelinessPolicy.UNKNOWN),
        told.lease,
        verbatim,
    )

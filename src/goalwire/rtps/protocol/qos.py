"""QoS of writers and readers: its encoding, its defaults, and the rules by which the two match."""

from __future__ import annotations

import struct
from fnmatch import fnmatchcase

from goalwire.records import record
from goalwire.rtps.protocol import parameters as pids
from goalwire.rtps.protocol.parameters import Parameters, read_texts, read_u32, write_texts
from goalwire.rtps.protocol.primitives import INFINITE, NS, RtpsError, decode_duration, encode_duration

BEST_EFFORT, RELIABLE = 1, 2
VOLATILE, TRANSIENT_LOCAL = 0, 1
AUTOMATIC, MANUAL_BY_PARTICIPANT, MANUAL_BY_TOPIC = 0, 1, 2
SHARED, EXCLUSIVE = 0, 1
KEEP_LAST, KEEP_ALL = 0, 1
XCDR1 = 0

_ORDERS = '><'


@record
class Qos:
    """The QoS of a writer or a reader. Durations are nanoseconds."""

    reliability: int = BEST_EFFORT
    max_blocking: int = NS // 10
    """How long a writer with KEEP_ALL may wait for room."""
    durability: int = VOLATILE
    depth: int = 1
    """How many samples are kept; 0: all; UNTOLD: a remote endpoint that does not tell it."""
    deadline: int = INFINITE
    lifespan: int = INFINITE
    liveliness: int = AUTOMATIC
    lease: int = INFINITE
    """The liveliness lease: within this time a writer must show that it lives."""
    ownership: int = SHARED
    partition: tuple[str, ...] = ()
    representation: tuple[int, ...] = (XCDR1,)
    """Encodings of payloads; a writer's first is the one that it uses."""


UNTOLD = -1
WRITER_DEFAULT = Qos(reliability=RELIABLE, depth=UNTOLD)
READER_DEFAULT = Qos(depth=UNTOLD)
"""The defaults for endpoints whose announcements leave policies out."""


def incompatible(offered: Qos, requested: Qos) -> str | None:
    """Return the first policy that keeps a writer and a reader from matching; None if they match.

    The names are those of DDS. The order of comparison is that of Cyclone DDS.
    """
    if offered.reliability < requested.reliability:
        return 'reliability'
    if offered.durability < requested.durability:
        return 'durability'
    if offered.deadline > requested.deadline:
        return 'deadline'
    if offered.ownership != requested.ownership:
        return 'ownership'
    if offered.liveliness < requested.liveliness or offered.lease > requested.lease:
        return 'liveliness'
    if offered.representation[0] not in requested.representation:
        return 'data representation'
    return None


def share_partition(offered: tuple[str, ...], requested: tuple[str, ...]) -> bool:
    """Return True if two endpoints share a partition.

    Wildcards in a name match only names without wildcards.
    """
    theirs = requested or ('',)
    return any(_is_same(one, other) for one in offered or ('',) for other in theirs)


def _is_same(one: str, other: str) -> bool:
    if one == other:
        return True
    wild, others_wild = _is_wild(one), _is_wild(other)
    if wild == others_wild:
        return False
    return fnmatchcase(other, one) if wild else fnmatchcase(one, other)


def _is_wild(name: str) -> bool:
    return '*' in name or '?' in name or '[' in name


def write_qos(qos: Qos) -> Parameters:
    """Return the parameters of an endpoint's QoS.

    A policy with the standard's default is left out, unless implementations disagree about the default.
    """
    listed = qos.representation
    told: Parameters = [
        (pids.RELIABILITY, struct.pack('<I', qos.reliability) + encode_duration(qos.max_blocking)),
        (pids.DURABILITY, struct.pack('<I', qos.durability)),
        (pids.REPRESENTATION, struct.pack(f'<I{len(listed)}h', len(listed), *listed)),
    ]
    if qos.depth != UNTOLD:
        history = struct.pack('<Ii', KEEP_LAST if qos.depth else KEEP_ALL, qos.depth or -1)
        told.insert(2, (pids.HISTORY, history))
    if qos.deadline != INFINITE:
        told.append((pids.DEADLINE, encode_duration(qos.deadline)))
    if qos.lifespan != INFINITE:
        told.append((pids.LIFESPAN, encode_duration(qos.lifespan)))
    if qos.liveliness != AUTOMATIC or qos.lease != INFINITE:
        told.append((pids.LIVELINESS_QOS, struct.pack('<I', qos.liveliness) + encode_duration(qos.lease)))
    if qos.ownership != SHARED:
        told.append((pids.OWNERSHIP, struct.pack('<I', qos.ownership)))
    if qos.partition:
        told.append((pids.PARTITION, write_texts(qos.partition)))
    return told


def read_qos(told: Parameters, order: int, default: Qos) -> Qos:
    """Read an endpoint's QoS from its parameters; raises RtpsError."""
    values = {name: getattr(default, name) for name in Qos.__match_args__}
    for pid, value in told:
        match pid:
            case pids.RELIABILITY:
                values['reliability'] = BEST_EFFORT if read_u32(value, order) == BEST_EFFORT else RELIABLE
                values['max_blocking'] = _duration(value, 4, order)
            case pids.DURABILITY:
                values['durability'] = read_u32(value, order)
            case pids.HISTORY:
                depth = read_u32(value[4:], order)
                values['depth'] = 0 if read_u32(value, order) == KEEP_ALL else max(1, depth & 0x7FFFFFFF)
            case pids.DEADLINE:
                values['deadline'] = _duration(value, 0, order)
            case pids.LIFESPAN:
                values['lifespan'] = _duration(value, 0, order)
            case pids.LIVELINESS_QOS:
                values['liveliness'] = read_u32(value, order)
                values['lease'] = _duration(value, 4, order)
            case pids.OWNERSHIP:
                values['ownership'] = read_u32(value, order)
            case pids.PARTITION:
                values['partition'] = read_texts(value, order)
            case pids.REPRESENTATION:
                count = read_u32(value, order)
                if count > len(value[4:]) // 2:
                    raise RtpsError(f'{count} data representations do not fit into {len(value)} bytes')
                listed = struct.unpack_from(f'{_ORDERS[order]}{count}h', value, 4)
                values['representation'] = listed or (XCDR1,)
    return Qos(**values)


def _duration(value: bytes, at: int, order: int) -> int:
    if len(value) < at + 8:
        raise RtpsError(f'a duration has {len(value) - at} bytes')
    return decode_duration(*struct.unpack_from(f'{_ORDERS[order]}iI', value, at))

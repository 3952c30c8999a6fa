"""Describes endpoints of the graph for `info --verbose`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.rules.qos import INFINITE_NS, UNSPECIFIED_NS, HistoryPolicy

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Json
    from goalwire.transport.contract import GraphEntity


def as_text(entity: GraphEntity, *, hash_title: str = 'Topic') -> str:
    """Return ROS 2's text of an endpoint."""
    qos = entity.qos.stated()
    depth = f' ({qos.depth})' if qos.history is HistoryPolicy.KEEP_LAST else ''
    return '\n'.join(
        [
            f'Node name: {entity.node.name}',
            f'Node namespace: {entity.node.namespace}',
            f'{hash_title} type: {entity.type_name}',
            f'{hash_title} type hash: {entity.type_hash or "INVALID"}',
            f'Endpoint type: {entity.kind.name}',
            f'GID: {".".join(format(byte, "02x") for byte in entity.gid)}',
            'QoS profile:',
            f'  Reliability: {qos.reliability.name}',
            f'  History (Depth): {qos.history.name}{depth}',
            f'  Durability: {qos.durability.name}',
            f'  Lifespan: {_duration(qos.lifespan_ns)}',
            f'  Deadline: {_duration(qos.deadline_ns)}',
            f'  Liveliness: {qos.liveliness.name}',
            f'  Liveliness lease duration: {_duration(qos.lease_ns)}',
        ]
    )


def as_json(entity: GraphEntity) -> Json:
    """Return an endpoint and its QoS for `--json`; durations in ns, None if they are endless."""
    qos = entity.qos.stated()
    return {
        'node': entity.node.qualified,
        'type': entity.type_name,
        'type_hash': entity.type_hash,
        'gid': entity.gid.hex(),
        'qos': {
            'reliability': qos.reliability.short_key,
            'history': qos.history.short_key,
            'depth': qos.depth,
            'durability': qos.durability.short_key,
            'lifespan': _or_none(qos.lifespan_ns),
            'deadline': _or_none(qos.deadline_ns),
            'liveliness': qos.liveliness.short_key,
            'lease_duration': _or_none(qos.lease_ns),
        },
    }


def _duration(ns: int) -> str:
    return 'Infinite' if ns in {INFINITE_NS, UNSPECIFIED_NS} else f'{ns} nanoseconds'


def _or_none(ns: int) -> int | None:
    return None if ns in {INFINITE_NS, UNSPECIFIED_NS} else ns

"""Shared by echo, hz, bw and delay: the topic's type, and a subscription that suits its publishers."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any, NamedTuple

import goalwire
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.entity_kinds import TOPICS
from goalwire.apps.cli.framework.live import refuse_other_type
from goalwire.apps.cli.framework.numbers import count
from goalwire.apps.cli.framework.qos import choose_qos
from goalwire.rules.qos import suiting
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from collections.abc import Sequence

    from goalwire.entities.type_support import MessageSupport
    from goalwire.graph.graph import Graph

QUEUE = 100
"""Default depth of the queue, in messages."""


class Source(NamedTuple):
    """A topic to read."""

    name: str
    cls: Any
    qos: goalwire.QoS


class RawSource(NamedTuple):
    """A topic whose messages are not decoded."""

    name: str
    type: MessageSupport
    qos: goalwire.QoS


def raw_source(arguments: Namespace, given: str) -> RawSource:
    """Return the named topic with a type, which may be unknown here, and a QoS. Raises CommandError."""
    from goalwire.observe.serialized_types import find_serialized_type

    name, type_name, graph = _one(arguments, given)
    return RawSource(
        name,
        find_serialized_type(graph, name, type_name),
        _qos(arguments, graph.entities(EndpointKind.PUBLISHER, name)),
    )


def source(arguments: Namespace, given: str, type_name: str | None = None) -> Source:
    """Return the named topic with its class and a QoS that suits its publishers. Raises CommandError."""
    if type_name is not None:
        name = lookup.full_name(given, 'topic')
        wanted = lookup.type_name(type_name, 'msg')
        cls, publishers = lookup.interface_in_use(wanted), _publishers(arguments, name)
        refuse_other_type(name, wanted, sorted({each.type_name for each in publishers}))
        return Source(name, cls, _qos(arguments, publishers))
    name, found, graph = _one(arguments, given)
    return Source(
        name, lookup.interface_in_use(found), _qos(arguments, graph.entities(EndpointKind.PUBLISHER, name))
    )


def _one(arguments: Namespace, given: str) -> tuple[str, str, Graph]:
    name, types, graph = TOPICS.one(arguments, given)
    return name, lookup.only_type(types, 'topic', name, arguments.prog), graph


def _publishers(arguments: Namespace, name: str) -> Sequence[Any]:
    from goalwire.apps.cli.framework.discovery import discovered

    with discovered(arguments, lambda graph: graph.count(EndpointKind.PUBLISHER, name) > 0) as graph:
        return graph.entities(EndpointKind.PUBLISHER, name)


def _qos(arguments: Namespace, publishers: Sequence[Any]) -> goalwire.QoS:
    base = suiting([publisher.qos for publisher in publishers], QUEUE)
    return choose_qos(arguments, base) if hasattr(arguments, 'qos_profile') else base


def window_argument(parser: ArgumentParser, default: int) -> None:
    """Add the option for the number of messages in a mean."""
    parser.add_argument(
        '-w',
        '--window',
        '--window-size',
        metavar='N',
        type=count,
        default=default,
        help=f'Number of messages in a mean (default: {default})',
    )

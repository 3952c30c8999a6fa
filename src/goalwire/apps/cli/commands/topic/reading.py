"""Shared by echo, hz, bw and delay: the topic's type, and a subscription that suits its publishers."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any, NamedTuple

import goalwire
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.live import refuse_other_type
from goalwire.apps.cli.framework.named import TOPICS
from goalwire.apps.cli.framework.numbers import count
from goalwire.apps.cli.framework.qos import choose_qos
from goalwire.rules.qos import suiting

if TYPE_CHECKING:
    from collections.abc import Sequence

QUEUE = 100
"""Messages that wait at most if no depth is asked for."""


class Source(NamedTuple):
    """A topic to read."""

    name: str
    cls: Any
    qos: goalwire.QoS


def source(arguments: Namespace, given: str, type_name: str | None = None) -> Source:
    """Return the topic that is named, its class, and a QoS that suits. Raises CommandError."""
    from goalwire.transport.contract import EndpointKind

    name = lookup.full_name(given, 'topic')
    if type_name is not None:
        wanted = lookup.type_name(type_name, 'msg')
        cls, publishers = lookup.interface_in_use(wanted), _publishers(arguments, name)
        refuse_other_type(name, wanted, sorted({each.type_name for each in publishers}))
        return Source(name, cls, _qos(arguments, publishers))
    name, types, graph = TOPICS.one(arguments, given)
    found = lookup.only_type(types, 'topic', name, arguments.prog)
    return Source(
        name, lookup.interface_in_use(found), _qos(arguments, graph.entities(EndpointKind.PUBLISHER, name))
    )


def _publishers(arguments: Namespace, name: str) -> Sequence[Any]:
    from goalwire.apps.cli.framework.discovery import discovered
    from goalwire.transport.contract import EndpointKind

    with discovered(arguments, lambda graph: graph.count(EndpointKind.PUBLISHER, name) > 0) as graph:
        return graph.entities(EndpointKind.PUBLISHER, name)


def _qos(arguments: Namespace, publishers: Sequence[Any]) -> goalwire.QoS:
    base = suiting([publisher.qos for publisher in publishers], QUEUE)
    return choose_qos(arguments, base) if hasattr(arguments, 'qos_profile') else base


def window_argument(parser: ArgumentParser, default: int) -> None:
    """Add the number of messages that a mean is taken of."""
    parser.add_argument(
        '-w',
        '--window',
        '--window-size',
        metavar='N',
        type=count,
        default=default,
        help=f'Messages that are taken together (default: {default})',
    )

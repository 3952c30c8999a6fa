"""The flags that choose a QoS, and the defaults."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

import goalwire
from goalwire.apps.cli.framework.numbers import length, seconds

PROFILES = ('default', 'services_default', 'parameters', 'parameter_events', 'sensor_data', 'system_default')
_RELIABILITY = ('system_default', 'reliable', 'best_effort', 'unknown', 'best_available')
_DURABILITY = ('system_default', 'transient_local', 'volatile', 'unknown', 'best_available')
_HISTORY = ('system_default', 'keep_last', 'keep_all', 'unknown')
_LIVELINESS = ('system_default', 'automatic', 'manual_by_topic', 'unknown', 'best_available')


def add_qos_arguments(parser: ArgumentParser, what: str, default: str) -> None:
    """Add ROS 2's flags of a QoS; `what` is 'publish' or 'subscribe'."""
    parser.add_argument(
        '--qos-profile', choices=PROFILES, help=f'QoS preset to {what} with (default: {default})'
    )
    parser.add_argument('--qos-depth', metavar='N', type=length, help='Depth of the queue')
    parser.add_argument('--qos-history', choices=_HISTORY, help='History of the queue')
    parser.add_argument('--qos-reliability', choices=_RELIABILITY, help='Reliability')
    parser.add_argument('--qos-durability', choices=_DURABILITY, help='Durability')
    parser.add_argument('--qos-liveliness', choices=_LIVELINESS, help='Liveliness')
    parser.add_argument(
        '--qos-liveliness-lease-duration-seconds', metavar='S', type=seconds, help='Lease of the liveliness'
    )


def choose_qos(arguments: Namespace, base: goalwire.QoS) -> goalwire.QoS:
    """Return the QoS of the flags; `base` is the default if no profile is named."""
    from goalwire.records import replace

    qos = base if arguments.qos_profile is None else _profile(arguments.qos_profile)
    changes: dict[str, object] = {}
    if arguments.qos_depth is not None:
        changes['depth'] = arguments.qos_depth
    if arguments.qos_history:
        changes['history'] = goalwire.HistoryPolicy[arguments.qos_history.upper()]
    if arguments.qos_reliability:
        changes['reliability'] = goalwire.ReliabilityPolicy[arguments.qos_reliability.upper()]
    if arguments.qos_durability:
        changes['durability'] = goalwire.DurabilityPolicy[arguments.qos_durability.upper()]
    if arguments.qos_liveliness:
        changes['liveliness'] = goalwire.LivelinessPolicy[arguments.qos_liveliness.upper()]
    lease = arguments.qos_liveliness_lease_duration_seconds
    if lease is not None and lease >= 0:
        changes['lease_ns'] = int(lease * 1e9)
    return replace(qos, **changes) if changes else qos


def _profile(name: str) -> goalwire.QoS:
    from goalwire.rules import qos

    return {
        'default': qos.DEFAULT,
        'services_default': qos.SERVICES_DEFAULT,
        'parameters': qos.PARAMETERS,
        'parameter_events': qos.PARAMETER_EVENTS,
        'sensor_data': qos.SENSOR_DATA,
        'system_default': qos.SYSTEM_DEFAULT,
    }[name]

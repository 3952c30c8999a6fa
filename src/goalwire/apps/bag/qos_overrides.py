"""Reads the QoS of topics from a YAML file in the format of rosbag2."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from goalwire.errors import BagError
from goalwire.files import LARGEST_PARAMETER_FILE, read_regular, show
from goalwire.rules.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoS,
    QoSPolicyEnum,
    ReliabilityPolicy,
)

_POLICIES: dict[str, type[QoSPolicyEnum]] = {
    'history': HistoryPolicy,
    'reliability': ReliabilityPolicy,
    'durability': DurabilityPolicy,
    'liveliness': LivelinessPolicy,
}
_DURATIONS = {'deadline': 'deadline_ns', 'lifespan': 'lifespan_ns', 'liveliness_lease_duration': 'lease_ns'}


def read_qos_overrides(path: str) -> dict[str, QoS]:
    """Return the QoS of each topic in a file. Raises BagError and FileNotFoundError."""
    import yaml

    try:
        found = yaml.safe_load(read_regular(path, LARGEST_PARAMETER_FILE))
    except FileNotFoundError:
        raise
    except (OSError, yaml.YAMLError) as error:
        raise BagError(f'{show(path)}: it cannot be read as YAML: {" ".join(str(error).split())}') from error
    if not isinstance(found, dict):
        raise BagError(f'{show(path)}: it does not map topics to QoS')
    return {str(topic): _qos(profile, f"{show(path)}: '{topic}'") for topic, profile in found.items()}


def _qos(profile: object, place: str) -> QoS:
    if not isinstance(profile, Mapping):
        raise BagError(f'{place}: its QoS does not map policies to values')
    values: dict[str, Any] = {}
    for key, value in profile.items():
        if key in _POLICIES:
            try:
                values[key] = _POLICIES[key][str(value).upper()]
            except KeyError:
                choice = ', '.join(_POLICIES[key].short_keys())
                raise BagError(f"{place}: {key} cannot be '{value}'; choose one of {choice}") from None
        elif key in _DURATIONS:
            values[_DURATIONS[key]] = _nanoseconds(value, f'{place}: {key}')
        elif key == 'depth' and isinstance(value, int) and value >= 0:
            values[key] = value
        elif key == 'avoid_ros_namespace_conventions':
            values[key] = bool(value)
        else:
            raise BagError(f"{place}: there is no policy '{key}' with the value {value!r}")
    return QoS(**values)


def _nanoseconds(value: object, place: str) -> int:
    if (
        isinstance(value, Mapping)
        and isinstance(value.get('sec'), int)
        and isinstance(value.get('nsec'), int)
    ):
        total: int = value['sec'] * 1_000_000_000 + value['nsec']
        if total >= 0:
            return total
    raise BagError(f'{place} needs sec and nsec, both from 0 on')

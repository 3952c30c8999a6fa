"""USER_DATA of participants and endpoints ('key=value;' pairs), and the ids that tie a service's ends.

Source: rmw_cyclonedds_cpp src/rmw_node.cpp; rmw_dds_common src/qos.cpp.
"""

from __future__ import annotations

from typing import NamedTuple

GUID_PREFIX_SIZE = 12
REFUSALS = 'goalwire'
"""The key of a client that takes refusals (refusal.py); ROS 2 skips what it does not know."""


class EndpointData(NamedTuple):
    """What an endpoint says of itself; '' for what it does not say."""

    type_hash: str = ''
    service_id: str = ''
    client_id: str = ''
    takes_refusals: bool = False
    """Whether a client knows what refusal.py describes."""


def encode_participant(enclave: str) -> bytes:
    """Return a participant's user data."""
    return f'enclave={enclave};'.encode()


def enclave_of(data: bytes) -> str:
    """Return the enclave that a participant names, '' where it names none."""
    return _pairs(data).get('enclave', '')


def encode_endpoint(data: EndpointData) -> bytes:
    """Return an endpoint's user data, in ROS 2's order, goalwire's own key last."""
    pairs = (
        ('serviceid', data.service_id),
        ('clientid', data.client_id),
        ('typehash', data.type_hash),
        (REFUSALS, '1' if data.takes_refusals else ''),
    )
    return ''.join(f'{key}={value};' for key, value in pairs if value).encode()


def decode_endpoint(data: bytes) -> EndpointData:
    """Read an endpoint's user data; what cannot be read counts as not said."""
    pairs = _pairs(data)
    return EndpointData(
        pairs.get('typehash', ''), pairs.get('serviceid', ''), pairs.get('clientid', ''), REFUSALS in pairs
    )


def _pairs(data: bytes) -> dict[str, str]:
    fields = (field.partition('=') for field in data.decode(errors='replace').split(';'))
    return {key: value for key, is_pair, value in fields if is_pair and value.isprintable()}


def service_id(participant: bytes, number: int) -> str:
    """Return the id that the two ends of one client or server share: only its equality matters."""
    raw = participant[:GUID_PREFIX_SIZE] + number.to_bytes(4, 'big')
    first, *rest = raw
    return '.'.join([f'{first:2x}', *(f'{byte:x}' for byte in rest)])

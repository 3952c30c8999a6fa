"""The types that every node offers or publishes, by name: their classes are made when the first one is used.

A node's parameter services alone need forty classes, 100 ms to make, which most programs never touch.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Protocol, TypeVar

from goalwire.entities.type_support import MessageSupport, ServiceSupport

SERVICE_HASHES = {
    'lifecycle_msgs/srv/ChangeState': (
        'RIHS01_356fe34f0475a43acf54542013af4167b0e729f77ea22ffb045c6ad8e20668e5'
    ),
    'lifecycle_msgs/srv/GetAvailableStates': (
        'RIHS01_00a07d79d2207d71e81a8cbc1880e5d924cc16d4688ea8e8e06e443dc8f8aa1d'
    ),
    'lifecycle_msgs/srv/GetAvailableTransitions': (
        'RIHS01_59b7ecefce0982a8a844b9f2c4f14764c1c4543cc55e72924e2aa4adad83e9bc'
    ),
    'lifecycle_msgs/srv/GetState': (
        'RIHS01_800a0a5aae599782b02932de0caf563f6dc4e7e94b794eadde075ba2cbef9795'
    ),
    'rcl_interfaces/srv/DescribeParameters': (
        'RIHS01_845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff'
    ),
    'rcl_interfaces/srv/GetLoggerLevels': (
        'RIHS01_03bf1bebd0d6514c7ed0ba7c5e08dc9f2f39c759fe99e1e30ea4157d7674f72d'
    ),
    'rcl_interfaces/srv/GetParameterTypes': (
        'RIHS01_da199c878688b3e530bdfe3ca8f74cb9fa0c303101e980a9e8f260e25e1c80ca'
    ),
    'rcl_interfaces/srv/GetParameters': (
        'RIHS01_bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc'
    ),
    'rcl_interfaces/srv/ListParameters': (
        'RIHS01_3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d'
    ),
    'rcl_interfaces/srv/SetLoggerLevels': (
        'RIHS01_3ff86cb4e91fbf9abae15c234ecc874448de6ece8e193401c077cf116e4f6d78'
    ),
    'rcl_interfaces/srv/SetParameters': (
        'RIHS01_56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0'
    ),
    'rcl_interfaces/srv/SetParametersAtomically': (
        'RIHS01_0e192ef259c07fc3c07a13191d27002222e65e00ccec653ca05e856f79285fcd'
    ),
    'type_description_interfaces/srv/GetTypeDescription': (
        'RIHS01_69b9c19c1021405984cc60dbbb1edceb147a6538b411d812ba6afabeed962cd5'
    ),
}
"""REP-2016 hashes, as `goalwire.idl.type_hash` computes them."""

MESSAGE_HASHES = {
    'lifecycle_msgs/msg/TransitionEvent': (
        'RIHS01_d5f8873a2f0146498f812d7885c7327ce27e463d36811d8792f35ee38c0d6c38',
        False,
    ),
    'rcl_interfaces/msg/Log': (
        'RIHS01_e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac',
        False,
    ),
    'rcl_interfaces/msg/ParameterEvent': (
        'RIHS01_043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204',
        True,
    ),
    'rosgraph_msgs/msg/Clock': (
        'RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564',
        False,
    ),
}

T_co = TypeVar('T_co', covariant=True)


class MakeService(Protocol[T_co]):
    """How a front makes a service of its own kind, one of those that every node has."""

    def __call__(self, support: ServiceSupport, name: str, callback: Callable[..., object], /) -> T_co: ...


@cache
def standard_service(type_name: str) -> ServiceSupport:
    """Return the support of 'pkg/srv/Name', one of SERVICE_HASHES."""

    def part_hashes() -> tuple[str, str]:
        from goalwire.entities.standard_part_hashes import PART_HASHES

        return PART_HASHES[type_name]

    return ServiceSupport(type_name, SERVICE_HASHES[type_name], _finder(type_name), part_hashes)


@cache
def standard_message(type_name: str) -> MessageSupport:
    """Return the support of 'pkg/msg/Name', one of MESSAGE_HASHES."""
    type_hash, has_buffers = MESSAGE_HASHES[type_name]
    return MessageSupport(type_name, type_hash, has_buffers, _finder(type_name))


def _finder(type_name: str) -> Callable[[], type]:
    def find() -> type:
        from importlib import import_module

        package, kind, name = type_name.split('/')
        found: type = getattr(import_module(f'{package}.{kind}'), name)
        return found

    return find

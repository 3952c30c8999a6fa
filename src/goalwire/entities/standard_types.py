"""The message and service types that every node needs. Their classes are made at the first use.

A node's parameter services alone need forty classes. They take 100 ms to make, and most programs never use
them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Protocol, TypeVar

from goalwire.entities.type_support import MessageSupport, ServiceSupport

if TYPE_CHECKING:
    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.rules.qos import QoS

try:
    from goalwire.entities.standard_hashes import MESSAGES, SERVICES  # written by the build
# In a checkout that was never installed each hash is computed when it is first asked for
except ModuleNotFoundError:
    MESSAGES, SERVICES = {}, {}

T_co = TypeVar('T_co', covariant=True)


class MakeService(Protocol[T_co]):
    """How an API makes one of the services that every node has, as a service of its own kind."""

    def __call__(
        self,
        support: ServiceSupport,
        name: str,
        callback: Callable[..., object],
        qos: QoS,
        group: CallbackGroup | None = None,
        /,
    ) -> T_co: ...


@cache
def standard_service(type_name: str) -> ServiceSupport:
    """Return the support of 'pkg/srv/Name'."""
    known = SERVICES.get(type_name)
    if known is None:
        from goalwire.cdr.type_hash import service_hashes

        known = service_hashes(type_name)
    type_hash, of_request, of_response = known
    return ServiceSupport(type_name, type_hash, _finder(type_name), lambda: (of_request, of_response))


@cache
def standard_message(type_name: str) -> MessageSupport:
    """Return the support of 'pkg/msg/Name'."""
    known = MESSAGES.get(type_name)
    if known is None:
        from goalwire.cdr.type_hash import message_facts

        known = message_facts(type_name)
    return MessageSupport(type_name, *known, _finder(type_name))


def _finder(type_name: str) -> Callable[[], type]:
    def find() -> type:
        from importlib import import_module

        package, kind, name = type_name.split('/')
        found: type = getattr(import_module(f'{package}.{kind}'), name)
        return found

    return find

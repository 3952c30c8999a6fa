"""What an entity needs to know of a message, service or action class: its name, hash and codec.

The texts of the refusals are rclpy's (rclpy.type_support).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol, TypeVar

from goalwire import interfaces
from goalwire.codec import cdr
from goalwire.transport.contract import Payload

_ROS1_HINT = (
    'This might be a ROS 1 message type but it should be a ROS 2 message type. '
    'Make sure to source your ROS 2 workspace after your ROS 1 workspace.'
)


RequestT_co = TypeVar('RequestT_co', covariant=True)
ResponseT_co = TypeVar('ResponseT_co', covariant=True)


class ServiceType(Protocol[RequestT_co, ResponseT_co]):
    """A service class as a type checker sees it, so that clients know their requests and responses."""

    @property
    def Request(self) -> type[RequestT_co]:  # noqa: N802 - rosidl's name
        """The request class."""

    @property
    def Response(self) -> type[ResponseT_co]:  # noqa: N802
        """The response class."""


@dataclass(frozen=True, slots=True)
class MessageSupport:
    """A message class as the wire knows it."""

    cls: type
    type_name: str
    type_hash: str
    has_buffers: bool
    encode: Callable[[object], bytes]
    decode: Callable[[Payload], Any]


@dataclass(frozen=True, slots=True)
class ServiceSupport:
    """A service class as the wire knows it."""

    cls: type
    type_name: str
    type_hash: str
    request: type
    response: type
    encode_request: Callable[[object], bytes]
    decode_request: Callable[[Payload], Any]
    encode_response: Callable[[object], bytes]
    decode_response: Callable[[Payload], Any]


@dataclass(frozen=True, slots=True)
class ActionSupport:
    """An action class, by the services and topics it is made of."""

    cls: type
    send_goal: ServiceSupport
    get_result: ServiceSupport
    cancel_goal: ServiceSupport
    feedback: MessageSupport
    status: MessageSupport


def check_for_type_support(cls: type) -> None:
    """Raise AttributeError for what is no message, service or action class."""
    if not hasattr(type(cls), '_TYPE_SUPPORT'):
        raise AttributeError(
            f"type object '{type(cls).__name__}' has no attribute '_TYPE_SUPPORT' {_ROS1_HINT}"
        )


def check_is_valid_msg_type(cls: type) -> None:
    """Raise RuntimeError for a service or action class, AttributeError for no interface class at all."""
    check_for_type_support(cls)
    if not hasattr(cls, 'get_fields_and_field_types'):
        raise RuntimeError(
            f'The message type provided is not valid ({cls}), this might be a service or action'
        )


def check_is_valid_srv_type(cls: type) -> None:
    """Raise RuntimeError for a message or action class, AttributeError for no interface class at all."""
    check_for_type_support(cls)
    if not (hasattr(cls, 'Request') and hasattr(cls, 'Response')):
        raise RuntimeError(
            f'The service type provided is not valid ({cls}), this might be a message or action'
        )


def message_support(cls: type) -> MessageSupport:
    """Return the support of a message class; raises as rclpy does for anything else."""
    return _message_support(cls)


@cache
def _message_support(cls: type) -> MessageSupport:
    check_is_valid_msg_type(cls)
    return MessageSupport(
        cls,
        interfaces.type_name(cls),
        interfaces.type_hash(cls),
        interfaces.has_buffer_fields(cls),
        cdr.encoder(cls),
        cdr.decoder(cls),
    )


def service_support(cls: type) -> ServiceSupport:
    """Return the support of a service class; raises as rclpy does for anything else."""
    return _service_support(cls)


@cache
def _service_support(cls: type) -> ServiceSupport:
    check_is_valid_srv_type(cls)
    request: type = cls.Request  # type: ignore[attr-defined]  # checked above
    response: type = cls.Response  # type: ignore[attr-defined]
    return ServiceSupport(
        cls,
        interfaces.type_name(cls),
        interfaces.type_hash(cls),
        request,
        response,
        cdr.encoder(request),
        cdr.decoder(request),
        cdr.encoder(response),
        cdr.decoder(response),
    )


def action_support(cls: type) -> ActionSupport:
    """Return the support of an action class; raises AttributeError or RuntimeError for anything else."""
    return _action_support(cls)


@cache
def _action_support(cls: type) -> ActionSupport:
    check_for_type_support(cls)
    impl = getattr(cls, 'Impl', None)
    if impl is None:
        raise RuntimeError(
            f'The action type provided is not valid ({cls}), this might be a message or service'
        )
    return ActionSupport(
        cls,
        service_support(impl.SendGoalService),
        service_support(impl.GetResultService),
        service_support(impl.CancelGoalService),
        message_support(impl.FeedbackMessage),
        message_support(impl.GoalStatusMessage),
    )

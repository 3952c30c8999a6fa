"""Facts about a message, service or action class that entities need: its name, hash and codec.

The texts of the refusals are rclpy's (rclpy.type_support).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property
from operator import attrgetter
from types import ModuleType
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeAlias, TypeVar

from goalwire import idl
from goalwire.cdr import codec
from goalwire.errors import InterfaceError, NoTypeSupportImportedException
from goalwire.records import record
from goalwire.transport.contract import Payload

_ROS1_HINT = (
    'This might be a ROS 1 message type but it should be a ROS 2 message type. '
    'Make sure to source your ROS 2 workspace after your ROS 1 workspace.'
)

_OF_INTERFACES = ('get_fields_and_field_types', 'Request', 'Goal')
_support_of = attrgetter('_TYPE_SUPPORT')
"""Reads the type support under rosidl's name, as the metaclasses that rosidl generates have it."""

if TYPE_CHECKING:
    from typing_extensions import TypeVar as TypeVarWithDefault

    # Only type checkers need defaults: programs may write a bare Publisher or Client, as rclpy's own do.
    MsgT = TypeVarWithDefault('MsgT', default=Any)
    RequestT = TypeVarWithDefault('RequestT', default=Any)
    ResponseT = TypeVarWithDefault('ResponseT', default=Any)
else:
    MsgT = TypeVar('MsgT')
    RequestT = TypeVar('RequestT')
    ResponseT = TypeVar('ResponseT')
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


class BareService(Protocol):
    """A service class as the checker pyrefly sees it: for pyrefly a nested class is not a property."""

    Request: ClassVar[type[Any]]
    Response: ClassVar[type[Any]]


ServiceClass: TypeAlias = type[ServiceType[RequestT, ResponseT]] | type[BareService]
"""A service class, as create_service and create_client take it."""


class MessageSupport:
    """A message class as the wire knows it. The codec is made when it is first needed."""

    def __init__(self, type_name: str, type_hash: str, has_buffers: bool, find: Callable[[], type]) -> None:
        self.type_name = type_name
        self.type_hash = type_hash
        self.has_buffers = has_buffers
        self._find = find

    @cached_property
    def cls(self) -> type:
        """The message class."""
        return self._find()

    @cached_property
    def encode(self) -> Callable[[object], bytes]:
        """Turn a message into CDR; raises EncodeError."""
        return codec.encoder(self.cls)

    @cached_property
    def decode(self) -> Callable[[Payload], Any]:
        """Turn CDR into a message; raises DecodeError."""
        return codec.decoder(self.cls)

    @cached_property
    def decode_in_place(self) -> Callable[[Payload], Any]:
        """Turn CDR into a message whose sequences of numbers are views of it; raises DecodeError."""
        return codec.decoder(self.cls, in_place=True)


class ServiceSupport:
    """A service class as the wire knows it. Classes and codecs are made when they are first needed."""

    def __init__(
        self,
        type_name: str,
        type_hash: str,
        find: Callable[[], type],
        part_hashes: Callable[[], tuple[str, str]] | None = None,
    ) -> None:
        self.type_name = type_name
        self.type_hash = type_hash
        self.part_hashes = part_hashes or self._part_hashes
        """Returns the hashes of the request and of the response."""
        self._find = find

    def _part_hashes(self) -> tuple[str, str]:
        return idl.type_hash(self.request), idl.type_hash(self.response)

    @cached_property
    def cls(self) -> type:
        """The service class."""
        return self._find()

    @cached_property
    def request(self) -> type:
        """The request class."""
        found: type = self.cls.Request  # type: ignore[attr-defined]  # it is a service class
        return found

    @cached_property
    def response(self) -> type:
        """The response class."""
        found: type = self.cls.Response  # type: ignore[attr-defined]
        return found

    @cached_property
    def encode_request(self) -> Callable[[object], bytes]:
        """Turn a request into CDR; raises EncodeError."""
        return codec.encoder(self.request)

    @cached_property
    def decode_request(self) -> Callable[[Payload], Any]:
        """Turn CDR into a request; raises DecodeError."""
        return codec.decoder(self.request)

    @cached_property
    def encode_response(self) -> Callable[[object], bytes]:
        """Turn a response into CDR; raises EncodeError."""
        return codec.encoder(self.response)

    @cached_property
    def decode_response(self) -> Callable[[Payload], Any]:
        """Turn CDR into a response; raises DecodeError."""
        return codec.decoder(self.response)


@record
class ActionSupport:
    """An action class, by the services and topics it is made of."""

    cls: type
    send_goal: ServiceSupport
    get_result: ServiceSupport
    cancel_goal: ServiceSupport
    feedback: MessageSupport
    status: MessageSupport


_NEEDED = 'a class of a message, a service or an action is needed'


def _what_to_give(given: object) -> str:
    """Return advice on what to write instead of an object that is not an interface's class."""
    if isinstance(given, ModuleType):
        package, _, rest = given.__name__.partition('.')
        names = [name for name in dir(given) if name[0].isupper() and not name.startswith('Metaclass_')]
        place = f'{package}.{rest.partition(".")[0]}' if rest else f'{package}.msg'
        example = f', such as {place}.{names[0]}' if names else ''
        return f'{given.__name__} is a module: give a class of it{example}'
    if isinstance(given, str) and '/' in given:
        return f'{given!r} is a text: give the class, as goalwire.idl.get_interface({given!r}) returns it'
    if isinstance(given, str):
        return f'{given!r} is a text: write the class first and then the name, as in (CLASS, {given!r}, …)'
    return f'got {given!r}. {_ROS1_HINT}'


def _explain_kind(given: type, wanted: str) -> str:
    """Say which kind of interface was given, and which calls take it."""
    kind = 'action' if hasattr(given, 'Goal') else 'service' if hasattr(given, 'Request') else 'message'
    name = given.__name__
    calls = {
        'message': f'create_publisher({name}, …) and create_subscription({name}, …)',
        'service': f'create_service({name}, …) and create_client({name}, …)',
        'action': f'ActionServer(node, {name}, …) and ActionClient(node, {name}, …)',
    }
    return f'{name} is a {kind}, and a {wanted} is needed; a {kind} goes into {calls[kind]}'


def _refuse_instance(given: object) -> None:
    """Raise TypeError for a message in the place of its class."""
    if hasattr(given, 'get_fields_and_field_types') and not isinstance(given, type):
        name = type(given).__name__
        raise TypeError(f'this is a message of type {name}: give the class itself, {name} without ()')


def check_for_type_support(msg_or_srv_type: type) -> None:
    """Raise AttributeError for anything but a message, service or action class. Raises
    NoTypeSupportImportedException for a class that looks like one and has no type support. The classes of an
    installed ROS 2 need no compiled type support here.
    """
    metaclass: Any = type(msg_or_srv_type)
    if not hasattr(metaclass, '_TYPE_SUPPORT'):
        advice = _what_to_give(msg_or_srv_type)
        raise AttributeError(f'{_NEEDED}: {advice}')
    if any(hasattr(msg_or_srv_type, name) for name in _OF_INTERFACES):
        return
    if _support_of(metaclass) is None:
        metaclass.__import_type_support__()
    if _support_of(metaclass) is None:
        raise NoTypeSupportImportedException


def check_is_valid_msg_type(msg_type: type) -> None:
    """Raise RuntimeError for a service or action class, AttributeError for any other object."""
    check_for_type_support(msg_type)
    if not hasattr(msg_type, 'get_fields_and_field_types'):
        raise RuntimeError(f'The message type provided is not valid: {_explain_kind(msg_type, "message")}')


def check_is_valid_srv_type(srv_type: type) -> None:
    """Raise RuntimeError for a message or action class, AttributeError for any other object."""
    check_for_type_support(srv_type)
    if not (hasattr(srv_type, 'Request') and hasattr(srv_type, 'Response')):
        raise RuntimeError(f'The service type provided is not valid: {_explain_kind(srv_type, "service")}')


def message_support(cls: type) -> MessageSupport:
    """Return the support of a message class; raises as rclpy does for anything else."""
    _refuse_instance(cls)
    return _message_support(cls)


@cache
def _message_support(cls: type) -> MessageSupport:
    check_is_valid_msg_type(cls)
    return MessageSupport(
        idl.type_name(cls),
        idl.type_hash(cls),
        idl.has_buffer_fields(cls),
        lambda: cls,
    )


def find_message_support(type_name: str, type_hash: str = '') -> MessageSupport:
    """Return the support of 'pkg/msg/Name', which may be unknown here: serialized messages need no class.

    Without a `type_hash` the hash of the definition known here is used, if there is one.
    """
    from goalwire.cdr.type_hash import message_facts  # imported here, since that module imports json

    try:
        known_hash, has_buffers = message_facts(type_name)
    except InterfaceError:
        known_hash, has_buffers = '', False
    return MessageSupport(
        type_name, type_hash or known_hash, has_buffers, lambda: idl.get_interface(type_name)
    )


def service_support(cls: type) -> ServiceSupport:
    """Return the support of a service class; raises as rclpy does for anything else."""
    _refuse_instance(cls)
    return _service_support(cls)


@cache
def _service_support(cls: type) -> ServiceSupport:
    check_is_valid_srv_type(cls)
    return ServiceSupport(idl.type_name(cls), idl.type_hash(cls), lambda: cls)


def action_support(cls: type, name: object = None, *, call: str = '') -> ActionSupport:
    """Return the support of an action class; raises AttributeError or RuntimeError for anything else.

    `call` and `name` are for the error's advice if the class and the name were given in the wrong order.
    """
    given: object = cls
    if call and isinstance(given, str) and '/' not in given:
        right = call.format(name.__name__ if isinstance(name, type) else 'CLASS', repr(given))
        raise AttributeError(
            f'{_NEEDED}: {given!r} is a text: the class stands before the name: write {right}'
        )
    _refuse_instance(cls)
    return _action_support(cls)


@cache
def _action_support(cls: type) -> ActionSupport:
    check_for_type_support(cls)
    impl = getattr(cls, 'Impl', None)
    if impl is None:
        raise RuntimeError(f'The action type provided is not valid: {_explain_kind(cls, "action")}')
    return ActionSupport(
        cls,
        service_support(impl.SendGoalService),
        service_support(impl.GetResultService),
        service_support(impl.CancelGoalService),
        message_support(impl.FeedbackMessage),
        message_support(impl.GoalStatusMessage),
    )

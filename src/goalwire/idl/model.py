"""The model of an interface definition, as plain data: no I/O, no classes, no wire format."""

from __future__ import annotations

from enum import Enum

from goalwire.patterns import Pattern
from goalwire.records import record

Scalar = bool | int | float | str | bytes
Default = Scalar | tuple[Scalar, ...]

INTEGER_BITS = {
    'int8': 8, 'uint8': 8, 'int16': 16, 'uint16': 16, 'int32': 32, 'uint32': 32, 'int64': 64, 'uint64': 64,
}  # fmt: skip
FLOATS = frozenset({'float32', 'float64'})
STRINGS = frozenset({'string', 'wstring'})
PRIMITIVES = frozenset({'bool', 'byte', 'char'}) | INTEGER_BITS.keys() | FLOATS | STRINGS

# rosidl gives a message without fields this one-byte field, because C has no empty struct. The field is in
# the type hash and on the wire, never in the Python class.
EMPTY_MEMBER = 'structure_needs_at_least_one_member'

_WORD = Pattern('(.)([A-Z][a-z]+)')
_BOUNDARY = Pattern('([a-z0-9])([A-Z])')
_UNIT = Pattern(r'\[([^\[\],\d\s][^\[\],]*)\]')


class Shape(Enum):
    """How many values a field holds."""

    SINGLE = 0
    ARRAY = 1  # exactly `capacity`
    BOUNDED = 2  # at most `capacity`
    UNBOUNDED = 3


@record
class FieldType:
    """The type of a field: `base` is a primitive's name or a message's full name (pkg/msg/Name)."""

    base: str
    shape: Shape = Shape.SINGLE
    capacity: int = 0
    string_capacity: int = 0  # 0: unbounded

    @property
    def is_message(self) -> bool:
        return '/' in self.base

    @property
    def is_string(self) -> bool:
        return self.base in STRINGS

    @property
    def is_number(self) -> bool:
        """True for integers, `char` and floats, which array.array and numpy hold; False for bool and byte."""
        return self.base in INTEGER_BITS or self.base in FLOATS or self.base == 'char'

    @property
    def is_sequence(self) -> bool:
        """True for bounded and unbounded sequences."""
        return self.shape in (Shape.BOUNDED, Shape.UNBOUNDED)

    @property
    def text(self) -> str:
        """The type as definition files write it: string<=5[3], geometry_msgs/Point[]."""
        base = self.base.replace('/msg/', '/') + (f'<={self.string_capacity}' if self.string_capacity else '')
        ends = {Shape.SINGLE: '', Shape.UNBOUNDED: '[]', Shape.ARRAY: f'[{self.capacity}]'}
        return base + ends.get(self.shape, f'[<={self.capacity}]')


def integer_range(base: str) -> tuple[int, int]:
    """Return the least and the greatest value of an integer type (`char` is an uint8 in ROS 2)."""
    bits = INTEGER_BITS['uint8' if base == 'char' else base]
    return (0, 2**bits - 1) if base[0] in 'uc' else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)


@record
class Field:
    """A field of a message; `line` is its line in the definition file, from 1, or 0 if it is in no file."""

    name: str
    type: FieldType
    default: Default | None = None
    comment: str = ''
    line: int = 0

    @property
    def unit(self) -> str:
        """The unit that the comment has in square brackets, such as rad/s; '' if it has none."""
        found = _UNIT.search(self.comment)
        return found[1] if found else ''


@record
class Constant:
    """A constant of a message."""

    name: str
    base: str
    value: Scalar
    comment: str = ''


@record
class MessageDefinition:
    """A message definition; `kind` is the folder of its file: msg, srv or action."""

    package: str
    kind: str
    name: str
    fields: tuple[Field, ...] = ()
    constants: tuple[Constant, ...] = ()
    comment: str = ''
    source: str = ''

    COMPARE_EXCLUDE = ('source',)

    @property
    def full_name(self) -> str:
        return f'{self.package}/{self.kind}/{self.name}'


@record
class ServiceDefinition:
    """A service definition with its three messages: request, response and event."""

    package: str
    kind: str
    name: str
    request: MessageDefinition
    response: MessageDefinition
    event: MessageDefinition

    @property
    def full_name(self) -> str:
        return f'{self.package}/{self.kind}/{self.name}'

    @property
    def messages(self) -> tuple[MessageDefinition, ...]:
        return (self.request, self.response, self.event)


@record
class ActionDefinition:
    """An action definition with its messages and services, those that ROS 2 derives included."""

    package: str
    kind: str
    name: str
    goal: MessageDefinition
    result: MessageDefinition
    feedback: MessageDefinition
    send_goal: ServiceDefinition
    get_result: ServiceDefinition
    feedback_message: MessageDefinition

    @property
    def full_name(self) -> str:
        return f'{self.package}/{self.kind}/{self.name}'

    @property
    def messages(self) -> tuple[MessageDefinition, ...]:
        return (
            self.goal, self.result, self.feedback, self.feedback_message,
            *self.send_goal.messages, *self.get_result.messages,
        )  # fmt: skip


Definition = MessageDefinition | ServiceDefinition | ActionDefinition


def module_name(type_name: str) -> str:
    """Return '_set_bool' for 'SetBool', '_tf2_error' for 'TF2Error', '_u_int8' for 'UInt8'.

    rosidl's rule (convert_camel_case_to_lower_case_underscore): an underscore before each capital that starts
    a word and between a small letter or digit and a capital, then all in lower case.
    """
    spaced = _BOUNDARY.sub(r'\1_\2', _WORD.sub(r'\1_\2', type_name))
    return '_' + spaced.lower()

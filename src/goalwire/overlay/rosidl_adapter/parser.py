"""rosidl_adapter.parser: parses .msg, .srv and .action files into specifications, for ROS 2's tools.

Goalwire makes its message classes by another parser, goalwire.idl.grammar, which is stricter.
"""

from __future__ import annotations

import re
import sys
import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final, TypedDict

from rosidl_adapter._names import (
    VALID_CONSTANT_NAME_PATTERN,
    VALID_FIELD_NAME_PATTERN,
    VALID_MESSAGE_NAME_PATTERN,
    VALID_PACKAGE_NAME_PATTERN,
    InvalidActionSpecification,
    InvalidFieldDefinition,
    InvalidResourceName,
    InvalidServiceSpecification,
    InvalidSpecification,
    UnknownMessageType,
    is_valid_constant_name,
    is_valid_field_name,
    is_valid_message_name,
    is_valid_package_name,
)
from rosidl_adapter._types import (
    ARRAY_UPPER_BOUND_TOKEN,
    PACKAGE_NAME_MESSAGE_TYPE_SEPARATOR,
    PRIMITIVE_TYPES,
    STRING_UPPER_BOUND_TOKEN,
    BaseType,
    InvalidValue,
    Primitive,
    Type,
    find_matching_end_quote,
    parse_primitive_value_string,
    parse_string_array_value_string,
    parse_value_string,
)

__all__ = [
    'ACTION_FEEDBACK_MESSAGE_SUFFIX',
    'ACTION_FEEDBACK_SUFFIX',
    'ACTION_GOAL_SERVICE_SUFFIX',
    'ACTION_GOAL_SUFFIX',
    'ACTION_REQUEST_RESPONSE_SEPARATOR',
    'ACTION_RESULT_SERVICE_SUFFIX',
    'ACTION_RESULT_SUFFIX',
    'ARRAY_UPPER_BOUND_TOKEN',
    'COMMENT_DELIMITER',
    'CONSTANT_SEPARATOR',
    'PACKAGE_NAME_MESSAGE_TYPE_SEPARATOR',
    'PRIMITIVE_TYPES',
    'SERVICE_EVENT_MESSAGE_SUFFIX',
    'SERVICE_REQUEST_MESSAGE_SUFFIX',
    'SERVICE_REQUEST_RESPONSE_SEPARATOR',
    'SERVICE_RESPONSE_MESSAGE_SUFFIX',
    'STRING_UPPER_BOUND_TOKEN',
    'VALID_CONSTANT_NAME_PATTERN',
    'VALID_FIELD_NAME_PATTERN',
    'VALID_MESSAGE_NAME_PATTERN',
    'VALID_PACKAGE_NAME_PATTERN',
    'ActionSpecification',
    'BaseType',
    'Constant',
    'Field',
    'InvalidActionSpecification',
    'InvalidFieldDefinition',
    'InvalidResourceName',
    'InvalidServiceSpecification',
    'InvalidSpecification',
    'InvalidValue',
    'MessageSpecification',
    'ServiceSpecification',
    'Type',
    'UnknownMessageType',
    'extract_file_level_comments',
    'find_matching_end_quote',
    'is_valid_constant_name',
    'is_valid_field_name',
    'is_valid_message_name',
    'is_valid_package_name',
    'parse_action_file',
    'parse_action_string',
    'parse_message_file',
    'parse_message_string',
    'parse_primitive_value_string',
    'parse_service_file',
    'parse_service_string',
    'parse_string_array_value_string',
    'parse_value_string',
    'process_comments',
    'validate_field_types',
]

COMMENT_DELIMITER: Final = '#'
CONSTANT_SEPARATOR: Final = '='
SERVICE_REQUEST_RESPONSE_SEPARATOR: Final = '---'
SERVICE_REQUEST_MESSAGE_SUFFIX: Final = '_Request'
SERVICE_RESPONSE_MESSAGE_SUFFIX: Final = '_Response'
SERVICE_EVENT_MESSAGE_SUFFIX: Final = '_Event'
ACTION_REQUEST_RESPONSE_SEPARATOR: Final = '---'
ACTION_GOAL_SUFFIX: Final = '_Goal'
ACTION_RESULT_SUFFIX: Final = '_Result'
ACTION_FEEDBACK_SUFFIX: Final = '_Feedback'
ACTION_GOAL_SERVICE_SUFFIX: Final = '_Goal'
ACTION_RESULT_SERVICE_SUFFIX: Final = '_Result'
ACTION_FEEDBACK_MESSAGE_SUFFIX: Final = '_Feedback'

_UNIT = re.compile(r'(\s*\[([^,\]]+)\])')


class Annotations(TypedDict, total=False):
    """The annotations of a definition: its comment lines, and the unit that they give in square brackets."""

    comment: list[str]
    unit: str


class Constant:
    """A constant of a definition.

    Raises TypeError, NameError, ValueError, InvalidValue for invalid arguments.
    """

    __slots__ = ['annotations', 'name', 'type', 'value']

    def __init__(self, primitive_type: str, name: str, value_string: str) -> None:
        if primitive_type not in PRIMITIVE_TYPES:
            raise TypeError(f"the constant type '{primitive_type}' must be a primitive type")
        _require(is_valid_constant_name(name), name, 'constant', VALID_CONSTANT_NAME_PATTERN)
        if value_string is None:
            raise ValueError("the constant value must not be 'None'")
        self.type = primitive_type
        self.name = name
        self.value: Primitive = parse_primitive_value_string(Type(primitive_type), value_string)
        self.annotations: Annotations = {}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Constant) and (
            (self.type, self.name, self.value) == (other.type, other.name, other.value)
        )

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        value = f"'{self.value}'" if self.type in ('string', 'wstring') else self.value
        return f'{self.type} {self.name}{CONSTANT_SEPARATOR}{value}'


class Field:
    """A field of a definition. Raises TypeError, NameError and InvalidValue for invalid arguments."""

    def __init__(self, type_: Type, name: str, default_value_string: str | None = None) -> None:
        if not isinstance(type_, Type):
            raise TypeError(f"the field type '{type_}' must be a 'Type' instance")
        _require(is_valid_field_name(name), name, 'field', VALID_FIELD_NAME_PATTERN)
        self.type = type_
        self.name = name
        self.default_value: Primitive | list[Primitive] | None = (
            None if default_value_string is None else parse_value_string(type_, default_value_string)
        )
        self.annotations: Annotations = {}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Field) and (
            (self.type, self.name, self.default_value) == (other.type, other.name, other.default_value)
        )

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        text = f'{self.type} {self.name}'
        if self.default_value is None:
            return text
        quoted = not self.type.is_array and self.type.type in ('string', 'wstring')
        return f"{text} '{self.default_value}'" if quoted else f'{text} {self.default_value}'


class MessageSpecification:
    """The definition of a message. Raises TypeError and ValueError for invalid fields and constants."""

    def __init__(
        self, pkg_name: str, msg_name: str, fields: Iterable[Field], constants: Iterable[Constant]
    ) -> None:
        self.base_type = BaseType(f'{pkg_name}{PACKAGE_NAME_MESSAGE_TYPE_SEPARATOR}{msg_name}')
        self.msg_name = msg_name
        self.annotations: Annotations = {}
        self.fields: list[Field] = list(fields)
        self.constants: list[Constant] = list(constants)
        _check_members('field', Field, self.fields)
        _check_members('constant', Constant, self.constants)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, MessageSpecification) and (
            (self.base_type, self.fields, self.constants) == (other.base_type, other.fields, other.constants)
        )

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        return '\n'.join([f'# {self.base_type}', *map(str, self.constants), *map(str, self.fields)])


class ServiceSpecification:
    """A service."""

    def __init__(
        self, pkg_name: str, srv_name: str, request: MessageSpecification, response: MessageSpecification
    ) -> None:
        _require_messages(request, response)
        self.pkg_name = pkg_name
        self.srv_name = srv_name
        self.request = request
        self.response = response

    def __str__(self) -> str:
        parts = f'{self.request}\n{SERVICE_REQUEST_RESPONSE_SEPARATOR}\n{self.response}'
        return f'# {self.pkg_name}/{self.srv_name}\n{parts}'


class ActionSpecification:
    """An action."""

    def __init__(
        self,
        pkg_name: str,
        action_name: str,
        goal: MessageSpecification,
        result: MessageSpecification,
        feedback: MessageSpecification,
    ) -> None:
        _require_messages(goal, result, feedback)
        self.pkg_name = pkg_name
        self.action_name = action_name
        self.goal = goal
        self.result = result
        self.feedback = feedback


def parse_message_file(pkg_name: str, interface_filename: str) -> MessageSpecification:
    """Parse a .msg file. Raises OSError, and as parse_message_string."""
    return parse_message_string(pkg_name, *_name_and_text(interface_filename))


def parse_service_file(pkg_name: str, interface_filename: str) -> ServiceSpecification:
    """Parse a .srv file. Raises OSError, and as parse_service_string."""
    return parse_service_string(pkg_name, *_name_and_text(interface_filename))


def parse_action_file(pkg_name: str, interface_filename: str) -> ActionSpecification:
    """Parse an .action file. Raises OSError, and as parse_action_string."""
    return parse_action_string(pkg_name, *_name_and_text(interface_filename))


def parse_service_string(pkg_name: str, srv_name: str, message_string: str) -> ServiceSpecification:
    """Parse the text of a .srv file. Raises InvalidServiceSpecification, and as parse_message_string."""
    parts = _parts(message_string, SERVICE_REQUEST_RESPONSE_SEPARATOR)
    if len(parts) != 2:
        unique = 'unique ' if len(parts) > 2 else ''
        raise InvalidServiceSpecification(
            f"Could not find {unique}separator '{SERVICE_REQUEST_RESPONSE_SEPARATOR}' "
            'between request and response'
        )
    suffixes = (SERVICE_REQUEST_MESSAGE_SUFFIX, SERVICE_RESPONSE_MESSAGE_SUFFIX)
    messages = [
        parse_message_string(pkg_name, srv_name + suffix, part)
        for suffix, part in zip(suffixes, parts, strict=True)
    ]
    return ServiceSpecification(pkg_name, srv_name, *messages)


def parse_action_string(pkg_name: str, action_name: str, action_string: str) -> ActionSpecification:
    """Parse the text of an .action file. Raises InvalidActionSpecification, and as parse_message_string."""
    parts = _parts(action_string, ACTION_REQUEST_RESPONSE_SEPARATOR)
    if len(parts) != 3:
        raise InvalidActionSpecification(
            f"Number of '{ACTION_REQUEST_RESPONSE_SEPARATOR}' separators nonconformant with action definition"
        )
    suffixes = (ACTION_GOAL_SUFFIX, ACTION_RESULT_SUFFIX, ACTION_FEEDBACK_SUFFIX)
    messages = [
        parse_message_string(pkg_name, action_name + suffix, part)
        for suffix, part in zip(suffixes, parts, strict=True)
    ]
    return ActionSpecification(pkg_name, action_name, *messages)


def parse_message_string(pkg_name: str, msg_name: str, message_string: str) -> MessageSpecification:
    """Parse the text of a .msg file.

    Raises InvalidSpecification or a class derived from it, InvalidValue, NameError, TypeError and ValueError.
    An invalid field is also printed to the standard error.
    """
    heading, lines = extract_file_level_comments(message_string.replace('\t', ' '))
    fields: list[Field] = []
    constants: list[Constant] = []
    latest: Field | Constant | None = None
    waiting: list[str] = []  # comments above the field or constant that they describe
    for line in map(str.rstrip, lines):
        code, sign, comment = line.partition(COMMENT_DELIMITER)
        if sign:
            comment = comment.lstrip(COMMENT_DELIMITER)
            if code and not code.strip():  # an indented comment continues the comment above
                if latest is not None:
                    latest.annotations['comment'].append(comment)
                continue
            waiting.append(comment)
        if not code.rstrip():
            continue
        latest = _member(pkg_name, msg_name, code.strip())
        if isinstance(latest, Field):
            fields.append(latest)
        else:
            constants.append(latest)
        latest.annotations['comment'] = waiting
        waiting = []
    message = MessageSpecification(pkg_name, msg_name, fields, constants)
    message.annotations['comment'] = heading
    process_comments(message)
    members: list[Field | Constant] = [*fields, *constants]
    for member in members:
        process_comments(member)
    return message


def extract_file_level_comments(message_string: str) -> tuple[list[str], list[str]]:
    """Return the comment lines at the top of the file, without their `#`, and all lines after them."""
    lines = message_string.splitlines()
    end = next((at for at, line in enumerate(lines) if not line.startswith(COMMENT_DELIMITER)), len(lines))
    return [line.lstrip(COMMENT_DELIMITER) for line in lines[:end]], lines[end:]


def process_comments(instance: MessageSpecification | Field | Constant) -> None:
    """Clean up the comment lines in `annotations`.

    If they name exactly one unit, move it to the key `unit`.
    """
    lines = instance.annotations.get('comment')
    if lines is None:
        return
    units: list[tuple[str, str]] = _UNIT.findall('\n'.join(lines))
    if len(units) == 1:
        brackets, instance.annotations['unit'] = units[0]
        lines = [line.replace(brackets, '') for line in lines]
    while lines and not lines[0]:
        lines = lines[1:]
    while lines and not lines[-1]:
        lines = lines[:-1]
    single = [line for at, line in enumerate(lines) if line or lines[at - 1]]  # merges blank lines
    instance.annotations['comment'] = textwrap.dedent('\n'.join(single)).split('\n') if single else []


def validate_field_types(
    spec: MessageSpecification | ServiceSpecification | ActionSpecification,
    known_msg_types: Sequence[BaseType],
) -> None:
    """Raise UnknownMessageType for the first field whose message type is not known."""
    if isinstance(spec, MessageSpecification):
        kind, messages = 'Message', [spec]
    elif isinstance(spec, ServiceSpecification):
        kind, messages = 'Service', [spec.request, spec.response]
    elif isinstance(spec, ActionSpecification):
        kind, messages = 'Action', [spec.goal, spec.result, spec.feedback]
    else:
        raise AssertionError(f'Unknown specification type: {type(spec)}')  # noqa: TRY004 - as ROS 2's
    for field in (field for message in messages for field in message.fields):
        base_type = BaseType(BaseType.__str__(field.type))
        if not base_type.is_primitive_type() and base_type not in known_msg_types:
            raise UnknownMessageType(
                f"{kind} interface '{base_type}' contains an unknown field type: {field}"
            )


def _member(package: str, message: str, line: str) -> Field | Constant:
    """Return the field or constant that a line defines; the line has no comment."""
    type_text, _, rest = line.partition(' ')
    name, equals, value = rest.partition(CONSTANT_SEPARATOR)
    if not rest.strip():
        print('Error with:', package, message, line, file=sys.stderr)  # noqa: T201 - as ROS 2's does
        raise InvalidFieldDefinition(line)
    if equals:
        return Constant(type_text, name.strip(), value.lstrip())
    name, _, default = rest.lstrip().partition(' ')
    try:
        return Field(Type(type_text, context_package_name=package), name, default.lstrip() or None)
    except Exception as error:
        print(  # noqa: T201 - as ROS 2's does
            f"Error processing '{line}' of '{package}/{message}': '{error}'", file=sys.stderr
        )
        raise


def _name_and_text(file: str) -> tuple[str, str]:
    path = Path(file)
    return path.stem, path.read_text(encoding='utf-8')


def _parts(text: str, separator: str) -> list[str]:
    """Return the parts into which separator lines divide the text."""
    parts: list[list[str]] = [[]]
    for line in text.splitlines():
        if line == separator:
            parts.append([])
        else:
            parts[-1].append(line)
    return ['\n'.join(lines) for lines in parts]


def _require(valid: bool, name: str, kind: str, pattern: re.Pattern[str]) -> None:
    if not valid:
        raise NameError(f"'{name}' is an invalid {kind} name. It should have the pattern '{pattern.pattern}'")


def _require_messages(*messages: MessageSpecification) -> None:
    for message in messages:
        if not isinstance(message, MessageSpecification):
            raise AssertionError(f'{message!r} is no MessageSpecification')  # noqa: TRY004 - as ROS 2's


def _check_members(kind: str, cls: type, members: Sequence[Field] | Sequence[Constant]) -> None:
    for at, member in enumerate(members):
        if not isinstance(member, cls):
            raise TypeError(f"{kind} {at} must be a '{cls.__name__}' instance")
    names = [member.name for member in members]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f'the {kind}s iterable contains duplicate names: {", ".join(twice)}')

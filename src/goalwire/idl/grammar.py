"""Parses .msg, .srv and .action files into model objects.

One line holds one field (`type name [default]`) or one constant (`type NAME=value`); `#` starts a comment;
a line `---` separates the parts of a service or an action. Rules: ROS 2's "Interface definition" page and
rosidl_adapter. Every refusal is an InterfaceSyntaxError that names file, line and character.
"""

from __future__ import annotations

import re
from keyword import iskeyword

from goalwire.errors import InterfaceSyntaxError
from goalwire.files import show
from goalwire.idl import derived_types
from goalwire.idl.literals import closing_quote, parse_default, parse_scalar
from goalwire.idl.model import (
    PRIMITIVES,
    ActionDefinition,
    Constant,
    Field,
    FieldType,
    MessageDefinition,
    ServiceDefinition,
    Shape,
)
from goalwire.patterns import Pattern
from goalwire.records import record

_PACKAGE = Pattern(r'(?!.*__)(?!.*_$)[a-z][a-z0-9_]*')
_TYPE_NAME = Pattern(r'[A-Z][A-Za-z0-9]*')
_SPLIT = Pattern(r'([a-z0-9])([A-Z])')
_FIELD_NAME = Pattern(r'(?!.*__)(?!.*_$)[a-z][a-z0-9_]*')
_CONSTANT_NAME = Pattern(r'[A-Z](?:_?[A-Z0-9])*')
_LINE = Pattern(r'(\S++)(?:\s++([^\s=]++)\s*+(=?)\s*+(.*))?', re.DOTALL)
_QUOTED = Pattern(r'\s*+\S++\s++[^\s=]++\s*+=?\s*+(?=["\'])')  # possessive: parsed in linear time
_ARRAY = Pattern(r'(.*)\[([^\[\]]*)\]')
# The generated class has methods with the first two names, and an attribute with the third and an underscore
# before it. So no field may have these names.
_TAKEN = frozenset({'check_fields', 'get_fields_and_field_types', 'fields_and_field_types'})
_TAKEN_CONSTANTS = frozenset({'SLOT_TYPES'})
_SEPARATOR = '---'
_MAX_CAPACITY = 2**32 - 1  # a length on the wire is an uint32
_LONGEST_PROBLEM = 300  # characters of an error's text, since it may quote a line of any length
_HINTS = {
    'Header': 'std_msgs/Header',
    'time': 'builtin_interfaces/Time',
    'duration': 'builtin_interfaces/Duration',
    'int': 'int32',
    'float': 'float32',
    'double': 'float64',
    'str': 'string',
    'boolean': 'bool',
}


@record
class _Source:
    """The file and line of a text, for error messages."""

    name: str
    line: int = 1

    def error(self, column: int, problem: str) -> InterfaceSyntaxError:
        return InterfaceSyntaxError(self.name, self.line, column, show(problem, _LONGEST_PROBLEM))


def parse_message(text: str, package: str, name: str, *, source: str = '') -> MessageDefinition:
    """Parse the text of a .msg file; `source` is the file's name for error messages."""
    where = _check_names(package, name, 'msg', source)
    return _Message(where.name, package, 'msg').parse(name, text.splitlines(), 1)


def parse_service(text: str, package: str, name: str, *, source: str = '') -> ServiceDefinition:
    """Parse the text of a .srv file: request --- response."""
    where = _check_names(package, name, 'srv', source)
    request, response = _sections(text, where, package, 'srv', name, 'Request', 'Response')
    return derived_types.service(request, response)


def parse_action(text: str, package: str, name: str, *, source: str = '') -> ActionDefinition:
    """Parse the text of an .action file: goal --- result --- feedback."""
    where = _check_names(package, name, 'action', source)
    goal, result, feedback = _sections(text, where, package, 'action', name, 'Goal', 'Result', 'Feedback')
    return derived_types.action(goal, result, feedback)


def _check_names(package: str, name: str, kind: str, source: str) -> _Source:
    where = _Source(source or f'{package}/{kind}/{name}.{kind}', 0)
    if not _PACKAGE.fullmatch(package):
        raise where.error(
            0, f'{package!r} is not a package name (a-z, 0-9 and single _, starting with a letter)'
        )
    if not _TYPE_NAME.fullmatch(name):
        raise where.error(0, f'{name!r} is not a type name (letters and digits, starting with a capital)')
    if iskeyword(name):
        raise where.error(0, f'{name!r} is taken by Python: rename the file, no type can have this name')
    return where


def _sections(
    text: str, where: _Source, package: str, kind: str, name: str, *suffixes: str
) -> list[MessageDefinition]:
    lines = text.splitlines()
    cuts = [index for index, line in enumerate(lines) if line.rstrip() == _SEPARATOR]
    wanted = len(suffixes) - 1
    if len(cuts) != wanted:
        parts = f' {_SEPARATOR} '.join(suffix.lower() for suffix in suffixes)
        at = cuts[wanted] + 1 if len(cuts) > wanted else max(len(lines), 1)
        if wanted == 1 and not cuts:
            raise _Source(where.name, at).error(
                1,
                f'{name}.{kind} has no line {_SEPARATOR!r}: write a line with only {_SEPARATOR} below the '
                'fields of the request; the fields of the response come below it',
            )
        raise _Source(where.name, at).error(
            1,
            f'found {len(cuts)} separator lines {_SEPARATOR!r}, a .{kind} has {wanted}: {parts}; '
            'write each on a line of its own',
        )
    starts = [0, *(cut + 1 for cut in cuts)]
    ends = [*cuts, len(lines)]
    return [
        _Message(where.name, package, kind).parse(f'{name}_{suffix}', lines[start:end], start + 1)
        for suffix, start, end in zip(suffixes, starts, ends, strict=True)
    ]


class _Message:
    """Collects the fields and constants of one message, and the comments around them."""

    def __init__(self, source: str, package: str, kind: str) -> None:
        self._source = source
        self._package = package
        self._kind = kind
        self._fields: list[Field] = []
        self._constants: list[Constant] = []
        self._comments: list[list[str]] = []  # the comments of fields and constants, in file order
        self._order: list[tuple[bool, int]] = []  # (is a constant, its index), in file order
        self._pending: list[str] = []  # comment lines that may belong to the next field or constant
        self._heading: list[str] = []
        self._seen: dict[str, int] = {}

    def parse(self, name: str, lines: list[str], first_line: int) -> MessageDefinition:
        for number, raw in enumerate(lines, first_line):
            self._line(raw.rstrip(), _Source(self._source, number))
        if not self._order:
            self._heading += self._pending
        comments: dict[tuple[bool, int], str] = {
            slot: '\n'.join(text) for slot, text in zip(self._order, self._comments, strict=True)
        }
        return MessageDefinition(
            self._package,
            self._kind,
            name,
            tuple(
                Field(item.name, item.type, item.default, comments[False, index], item.line)
                for index, item in enumerate(self._fields)
            ),
            tuple(
                Constant(item.name, item.base, item.value, comments[True, index])
                for index, item in enumerate(self._constants)
            ),
            '\n'.join(self._heading).strip(),
            self._source,
        )

    def _line(self, raw: str, where: _Source) -> None:
        code, comment = _split_comment(raw)
        if code.strip():
            self._definition(code, where)
            self._comments.append([*self._pending, *([comment] if comment else [])])
            self._pending = []
        elif not raw:
            if not self._order:  # a comment above a blank line at the top describes the whole message
                self._heading += [*self._pending, '']
            self._pending = []
        elif raw[0].isspace() and self._order and not self._pending:
            self._comments[-1].append(comment)  # an indented comment continues the comment above it
        else:
            self._pending.append(comment)

    def _definition(self, code: str, where: _Source) -> None:
        indent = len(code) - len(code.lstrip()) + 1
        match = _LINE.fullmatch(code.strip())
        if match is None:
            raise where.error(indent, f'{code.strip()!r} has no name (write: type name, or type NAME=value)')
        type_text, name, equals, value = match.groups()
        if name is None:
            raise where.error(indent, f'{type_text!r} has no name after it (write: type name)')
        column = indent + match.start(2)
        earlier = self._seen.setdefault(name, where.line)
        if earlier != where.line:
            raise where.error(column, f'{name!r} is already defined in line {earlier}')
        type_ = _parse_type(type_text, self._package, where, indent)
        value_column = indent + match.start(4)
        if equals:
            self._constant(type_, name, value, where, (indent, column, value_column))
        else:
            self._field(type_, name, value, where, (column, value_column))

    def _constant(
        self, type_: FieldType, name: str, value: str, where: _Source, columns: tuple[int, int, int]
    ) -> None:
        if type_.is_message or type_.shape is not Shape.SINGLE:
            raise where.error(
                columns[0], f'constant {name}: only single values of primitive types can be constants'
            )
        if not _CONSTANT_NAME.fullmatch(name):
            hint = ''
            if _FIELD_NAME.fullmatch(name):
                hint = f"; for a field with a default value write no '=': {type_.text} {name} {value.strip()}"
            raise where.error(columns[1], f'{name!r} is not a constant name (A-Z, 0-9 and single _){hint}')
        if name in _TAKEN_CONSTANTS:
            raise where.error(columns[1], f'{name!r} is taken by the generated class: rename the constant')
        if not value and not type_.is_string:
            raise where.error(columns[2], f'constant {name} has no value')
        try:
            constant = Constant(name, type_.base, parse_scalar(value, type_.base, type_.string_capacity))
        except ValueError as error:
            raise where.error(columns[2], f'constant {name}: {error}') from None
        self._order.append((True, len(self._constants)))
        self._constants.append(constant)

    def _field(
        self, type_: FieldType, name: str, value: str, where: _Source, columns: tuple[int, int]
    ) -> None:
        if not _FIELD_NAME.fullmatch(name):
            better = _SPLIT.sub(r'\1_\2', name.rstrip(';,')).lower()
            hint = f'; write {better}' if _FIELD_NAME.fullmatch(better) else ''
            raise where.error(
                columns[0],
                f'{name!r} is not a field name (a-z, 0-9 and single _, starting with a letter){hint}',
            )
        if iskeyword(name) or name in _TAKEN:
            owner = 'the generated class' if name in _TAKEN else 'Python'
            raise where.error(columns[0], f'{name!r} is taken by {owner}, no field can have this name')
        try:
            default = parse_default(value, type_) if value else None
        except ValueError as error:
            raise where.error(columns[1], f'field {name}: {error}') from None
        self._order.append((False, len(self._fields)))
        self._fields.append(Field(name, type_, default, line=where.line))


def _split_comment(line: str) -> tuple[str, str]:
    """Split a line at the `#` that starts its comment; a `#` inside a quoted value does not count."""
    at = line.find('#')
    value = _QUOTED.match(line)
    if value and value.end() < at:
        end = closing_quote(line[value.end() :])
        if end > 0:
            at = line.find('#', value.end() + end)
    if at < 0:
        return line, ''
    return line[:at].rstrip(), line[at:].lstrip('#').strip()


def _parse_type(text: str, package: str, where: _Source, column: int) -> FieldType:
    base, shape, capacity = text, Shape.SINGLE, 0
    array = _ARRAY.fullmatch(text)
    if array:
        base, size = array.groups()
        shape = Shape.UNBOUNDED if not size else Shape.BOUNDED if size.startswith('<=') else Shape.ARRAY
        if size:
            capacity = _capacity(size.removeprefix('<='), text, where, column + array.start(2))
    string_capacity = 0
    kind, bound, limit = base.partition('<=')
    if bound:
        if kind not in ('string', 'wstring'):
            raise where.error(column, f'{text!r}: only string and wstring can be bounded like this')
        base, string_capacity = kind, _capacity(limit, text, where, column + len(kind) + 2)
    return FieldType(_resolve(base, text, package, where, column), shape, capacity, string_capacity)


def _capacity(text: str, type_text: str, where: _Source, column: int) -> int:
    plain = text.isascii() and text.isdigit() and len(text.lstrip('0')) <= len(str(_MAX_CAPACITY))
    if not (plain and 0 < int(text.lstrip('0') or '0') <= _MAX_CAPACITY):
        raise where.error(column, f'{type_text!r}: {text!r} is not a size (a whole number from 1)')
    return int(text.lstrip('0'))


def _hint(base: str) -> str:
    """Return advice which type to write instead of an unknown one."""
    if base in _HINTS:
        return f' (write {_HINTS[base]})'
    from difflib import get_close_matches

    close = get_close_matches(base[:40], PRIMITIVES, n=1)
    return f'; did you mean {close[0]}?' if close else ''


def _resolve(base: str, text: str, package: str, where: _Source, column: int) -> str:
    """Return the name of a primitive, or a message's full name; a name without a package is in `package`."""
    if base in PRIMITIVES:
        return base
    *path, name = base.split('/')
    if len(path) == 2 and path[1] == 'msg':
        path.pop()
    if len(path) > 1 or not _TYPE_NAME.fullmatch(name) or not all(map(_PACKAGE.fullmatch, path)):
        raise where.error(column, f'{text!r} is not a type{_hint(base)}')
    return f'{path[0] if path else package}/msg/{name}'

"""Errors of messages and their definitions."""

from __future__ import annotations

from goalwire.errors.base import LocalError, RemoteError


class InterfaceError(LocalError, ImportError):
    """A .msg, .srv or .action cannot be used."""


class InterfaceSyntaxError(InterfaceError):
    """A definition breaks the grammar; `line` and `column` count from 1; 0: the place is unknown."""

    def __init__(self, source: str, line: int, column: int, problem: str) -> None:
        super().__init__(f'{source}:{line}:{column}: {problem}')
        self.source = source
        self.line = line
        self.column = column
        self.problem = problem


class UnknownInterfaceError(InterfaceError):
    """There is no such interface package, or the package has no such type."""


class NoTypeSupportImportedException(LocalError):
    """A class that was given as a message type has no type support."""

    def __init__(self) -> None:
        super().__init__('no type_support imported')


class EncodeError(LocalError):
    """A value does not fit its field; `field` is its path in the message of type `type_name`."""

    def __init__(self, type_name: str, field: str, problem: str) -> None:
        super().__init__(f'{type_name}: {field}: {problem}' if field else f'{type_name}: {problem}')
        self.type_name = type_name
        self.field = field


class EncodeTypeError(EncodeError, TypeError):
    """A value has the wrong type for its field."""


class EncodeValueError(EncodeError, ValueError):
    """A value has the right type, but the field cannot hold it."""


class UnknownFieldError(LocalError, AssertionError, TypeError):
    """A message's constructor got a keyword that names no field. rosidl raises AssertionError, Python
    TypeError.
    """


class FieldValueError(LocalError, ValueError):
    """A value does not fit its field or parameter, which `path` names.

    The path is '' if the whole message does not fit. `problem` says which value was given and which is
    needed; `reason` is the same text without the type at its end.
    """

    def __init__(self, path: str, reason: str, type_text: str = '') -> None:
        problem = f'{reason} ({type_text})' if type_text else reason
        super().__init__(f'{path}: {problem}' if path else problem)
        self.path = path
        self.problem = problem
        self.reason = reason


class DecodeError(RemoteError, ValueError):
    """The bytes are not a message of type `type_name`; `offset` is the position of the fault, header
    included.
    """

    def __init__(self, type_name: str, field: str, offset: int, problem: str) -> None:
        where = f'{field}: ' if field else ''
        super().__init__(f'{type_name}: {where}at byte {offset}: {problem}')
        self.type_name = type_name
        self.field = field
        self.offset = offset

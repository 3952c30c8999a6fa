"""The rules for names of packages, messages, fields and constants, and the errors for bad definitions."""

from __future__ import annotations

import re
from typing import Final

VALID_PACKAGE_NAME_PATTERN: Final = re.compile(r'^(?!.*__)(?!.*_$)[a-z][a-z0-9_]*$')
VALID_FIELD_NAME_PATTERN: Final = VALID_PACKAGE_NAME_PATTERN
VALID_MESSAGE_NAME_PATTERN: Final = re.compile(r'^[A-Z][A-Za-z0-9]*$')
VALID_CONSTANT_NAME_PATTERN: Final = re.compile(r'^[A-Z](?:_?[A-Z0-9])*$')
_DERIVED = ('_Request', '_Response', '_Goal', '_Result', '_Feedback')


class InvalidSpecification(Exception):
    """An error for a definition that breaks the rules of .msg, .srv and .action files."""


class InvalidActionSpecification(InvalidSpecification):
    """An error for a definition of an action that does not consist of three parts."""


class InvalidServiceSpecification(InvalidSpecification):
    """An error for a definition of a service that does not consist of two parts."""


class InvalidResourceName(InvalidSpecification):
    """An error for a type with an invalid name."""


class InvalidFieldDefinition(InvalidSpecification):
    """An error for a line that has no name after the type."""


class UnknownMessageType(InvalidSpecification):
    """An error for a field whose type is not known."""


def is_valid_package_name(name: str) -> bool:
    """Return whether a package's name is valid. Raises InvalidResourceName for anything but a string."""
    return _fits(VALID_PACKAGE_NAME_PATTERN, name)


def is_valid_field_name(name: str) -> bool:
    """Return whether a field's name is valid. Raises InvalidResourceName for anything but a string."""
    return _fits(VALID_FIELD_NAME_PATTERN, name)


def is_valid_constant_name(name: str) -> bool:
    """Return whether a constant's name is valid. Raises InvalidResourceName for anything but a string."""
    return _fits(VALID_CONSTANT_NAME_PATTERN, name)


def is_valid_message_name(name: str) -> bool:
    """Return whether a message's name is valid, also if it belongs to a service or an action.

    Raises InvalidResourceName for anything but a string.
    """
    if not isinstance(name, str):
        raise InvalidResourceName(name)
    plain = name.removeprefix('Sample_')
    for suffix in _DERIVED:
        plain = plain.removesuffix(suffix)
    return _fits(VALID_MESSAGE_NAME_PATTERN, plain)


def _fits(pattern: re.Pattern[str], name: str) -> bool:
    if not isinstance(name, str):
        raise InvalidResourceName(name)
    return pattern.fullmatch(name) is not None

"""Reads parameter files: those of this program (`--params-file`), and those to be sent to other nodes.

A program's files are read when it starts, so that mistakes are reported before a node is made. The syntax of
a program's files is in rules/parameters/file_syntax.py, that of the others in rules/parameters/plain_yaml.py.
"""

from __future__ import annotations

import os
from io import BytesIO
from typing import TYPE_CHECKING

from goalwire.errors import FileShapeError
from goalwire.files import LARGEST_PARAMETER_FILE, read_regular, show
from goalwire.records import replace
from goalwire.rules.arguments import ArgumentError, Arguments, ParameterFile
from goalwire.rules.names.lexer import RuleSyntaxError
from goalwire.rules.parameters.parameter import value_message
from goalwire.rules.parameters.plain_yaml import flat_values, read_typed_text, read_typed_value

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter as ParameterMessage
    from rcl_interfaces.msg import ParameterValue as ParameterValueMessage

    from goalwire.rules.parameters.file_syntax import NodeValues


def with_files_read(arguments: Arguments) -> Arguments:
    """Return the arguments with their parameter files' content; raises ArgumentError that names the file."""
    return replace(
        arguments,
        parameters=tuple(
            replace(item, nodes=_read(item.path)) if isinstance(item, ParameterFile) else item
            for item in arguments.parameters
        ),
    )


def _read(path: str) -> NodeValues:
    from goalwire.rules.parameters.file_syntax import parse_parameter_file

    try:
        empty = path == os.devnull  # /dev/null usually means: no file
        return parse_parameter_file(b'' if empty else read_regular(path, LARGEST_PARAMETER_FILE))
    except OSError as error:
        reason = f'Error opening YAML file: {error.strerror}'
        if isinstance(error, FileNotFoundError) and not os.path.isabs(path):  # noqa: PTH117
            reason += (
                ': correct the name, or give the whole path; the program looks in the folder in which it was '
                f'started, {os.getcwd()}'  # noqa: PTH109
            )
    except RuleSyntaxError as error:
        reason = str(error)
    except ValueError as error:  # there is a NUL in the path
        reason = f'Error opening YAML file: {error}'
    raise ArgumentError(f"Couldn't parse params file: '--params-file {show(path)}'. Error: {reason}")


def parameter_value_from_text(text: str) -> ParameterValueMessage:
    """Return the value of a YAML text; a text that is not of another YAML type is a string."""
    return value_message(*read_typed_text(text))


def parameters_from_yaml_file(
    path: str, target_nodes: list[str] | None, namespace: str, *, use_wildcard: bool
) -> dict[str, ParameterMessage]:
    """Return the parameters in a file, by their names with `namespace` in front.

    Raises OSError (also for what is not a regular file, or too large), yaml.YAMLError with file and line,
    FileShapeError (a RuntimeError).
    """
    import yaml
    from rcl_interfaces.msg import Parameter as ParameterMessage

    content = BytesIO(read_regular(path, LARGEST_PARAMETER_FILE))
    content.name = path  # YAML's errors name the line
    try:
        tree = yaml.safe_load(content)
    except yaml.YAMLError:
        raise
    except Exception as error:  # PyYAML raises exceptions of any kind
        raise FileShapeError(f'{path}: a value cannot be read: {error}') from None
    values = flat_values(tree, target_nodes, use_wildcard=use_wildcard)
    return {
        f'{namespace}{name}': ParameterMessage(
            name=f'{namespace}{name}', value=value_message(*read_typed_value(name, value))
        )
        for name, value in values.items()
    }


def values_from_yaml_file(path: str, node_name: str, *, use_wildcard: bool) -> dict[str, object]:
    """Return a file's parameters for one node, by names, as `read_yaml` returns them.

    Raises OSError (also for what is not a regular file, or too large), FieldValueError for what is not YAML,
    FileShapeError (a RuntimeError).
    """
    from goalwire.idl.field_values import read_yaml

    try:
        text = read_regular(path, LARGEST_PARAMETER_FILE).decode()
    except UnicodeDecodeError:
        raise FileShapeError(f'{path} is not a text in UTF-8') from None
    content = read_yaml(text)
    if use_wildcard and isinstance(content, dict) and set(content) == {'/**'}:
        return flat_values(content, None, use_wildcard=True)
    return flat_values(content, [node_name], use_wildcard=use_wildcard)

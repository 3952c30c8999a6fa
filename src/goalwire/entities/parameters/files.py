"""Reading the files that `--params-file` names: at once, so that mistakes are told before a node is made."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from goalwire.files import LARGEST_PARAMETER_FILE, read_regular, shown
from goalwire.records import replace
from goalwire.rules.arguments import ArgumentError, Arguments, ParameterFile
from goalwire.rules.names.lexer import RuleSyntaxError

if TYPE_CHECKING:
    from goalwire.rules.parameters.files import NodeValues


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
    from goalwire.rules.parameters.files import parse_parameter_file

    try:
        empty = path == os.devnull  # a usual way to say: no file
        return parse_parameter_file(b'' if empty else read_regular(path, LARGEST_PARAMETER_FILE))
    except OSError as error:
        reason = f'Error opening YAML file: {error.strerror}'
    except RuleSyntaxError as error:
        reason = str(error)
    except ValueError as error:  # a NUL in the path
        reason = f'Error opening YAML file: {error}'
    raise ArgumentError(f"Couldn't parse params file: '--params-file {shown(path)}'. Error: {reason}")

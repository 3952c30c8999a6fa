"""Reading the files that `--params-file` names: at once, so that mistakes are told before a node is made."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.protocol.arguments import ArgumentError, Arguments, ParameterFile
from goalwire.protocol.names.lexer import RuleSyntaxError
from goalwire.records import replace

if TYPE_CHECKING:
    from goalwire.protocol.parameters.files import NodeValues


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
    from goalwire.protocol.parameters.files import parse_parameter_file

    try:
        return parse_parameter_file(Path(path).read_bytes())
    except OSError as error:
        reason = f'Error opening YAML file: {error.strerror}'
    except RuleSyntaxError as error:
        reason = str(error)
    raise ArgumentError(f"Couldn't parse params file: '--params-file {path}'. Error: {reason}")

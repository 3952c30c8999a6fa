"""Checks launch files without launching them: finds the mistakes that show before a process starts."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from difflib import get_close_matches

import goalwire.launching.catalog  # noqa: F401 - it imports what launch files may name
from goalwire.errors import LaunchError, NoSuchPackageError
from goalwire.files import LARGEST_PARAMETER_FILE, read_regular, show
from goalwire.launching.actions import DeclareLaunchArgument
from goalwire.launching.errors import Location, as_sentence, locate
from goalwire.launching.model import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from goalwire.launching.ros.node import Node
from goalwire.launching.ros.parameters import Parameter, ParameterFile
from goalwire.launching.sources import (
    DEEPEST,
    IncludeLaunchDescription,
    get_launch_description_from_any_launch_file,
)
from goalwire.launching.values import perform_substitutions, perform_text
from goalwire.rules.names.lexer import RuleSyntaxError
from goalwire.rules.parameters.file_syntax import KEY, parse_parameter_file


def check_launch_file(path: str) -> list[str]:
    """List the mistakes in a launch file and in those that it includes, each as `file:line: mistake`.

    Texts that depend on arguments are checked with the defaults. Values that need a launch are not checked.
    """
    try:
        description = get_launch_description_from_any_launch_file(path)
    except Exception as error:
        told = locate(error, None)
        return [str(told) if told.located else f'{show(os.path.abspath(path))}:1: {told}']
    return list(dict.fromkeys(_problems(description, _context(path), 0)))


def _context(path: str) -> LaunchContext:
    context = LaunchContext()
    full = os.path.abspath(path)
    context.extend_globals(
        {'current_launch_file_path': full, 'current_launch_file_directory': os.path.dirname(full)}
    )
    return context


def _problems(description: LaunchDescription, context: LaunchContext, depth: int) -> Iterator[str]:
    for entity in _entities(description.entities):
        if isinstance(entity, DeclareLaunchArgument):
            _take_default(entity, context)
        elif isinstance(entity, Node):
            yield from _problems_of_node(entity, context)
        elif isinstance(entity, IncludeLaunchDescription) and depth < DEEPEST:
            yield from _problems_of_include(entity, context, depth)


def _entities(entities: Iterable[LaunchDescriptionEntity]) -> Iterator[LaunchDescriptionEntity]:
    """Yield all entities of a tree, also those that wait for an event, but not those of included files."""
    for entity in entities:
        yield entity
        yield from _entities(entity.describe_sub_entities())
        for _, inner in entity.describe_conditional_sub_entities():
            yield from _entities(inner)


def _take_default(argument: DeclareLaunchArgument, context: LaunchContext) -> None:
    if argument.default_value is not None and argument.name not in context.launch_configurations:
        with contextlib.suppress(Exception):
            default = perform_substitutions(context, argument.default_value)
            context.launch_configurations[argument.name] = default


def _problems_of_node(node: Node, context: LaunchContext) -> Iterator[str]:
    try:
        if not node.may_lack_program(context):
            node.process_description.command(context)
    except NoSuchPackageError as error:
        yield _line(node.location, error)
    except LaunchError as error:
        if 'executable' in str(error):
            yield _line(node.location, error)
    except Exception:
        return
    for item in node.given_parameters:
        if isinstance(item, Mapping | Parameter):
            continue
        try:
            path = perform_text(context, item.param_file if isinstance(item, ParameterFile) else item)
        except LaunchError as error:
            if isinstance(error, NoSuchPackageError):
                yield _line(node.location, error)
            continue
        if not os.path.isfile(path):
            yield _line(node.location, LaunchError(f'the parameter file {show(path)} does not exist'))
        elif not (isinstance(item, ParameterFile) and item.allow_substs):
            yield from _problems_of_parameter_file(path)


def _problems_of_parameter_file(path: str) -> Iterator[str]:
    """Yield the reasons why the node cannot read the parameter file."""
    try:
        parse_parameter_file(read_regular(path, LARGEST_PARAMETER_FILE))
    except OSError as error:
        yield f'{show(path)}:1: {error.strerror}'
    except RuleSyntaxError as error:
        text = ' '.join(str(error).split())
        place = re.search(r' (?:at line|near line|line_num) (\d+)', text)
        wrong = _misspelt_key(path)
        if wrong is not None:
            line, key = wrong
            yield f"{show(path)}:{line}: '{key}' is not a key of a parameter file; did you mean {KEY}?"
        else:
            yield f'{show(path)}:{place[1] if place else 1}: {text}'


def _misspelt_key(path: str) -> tuple[int, str] | None:
    """Return line and text of a key that is probably a misspelt `ros__parameters`; None if there is none."""
    text = read_regular(path, LARGEST_PARAMETER_FILE).decode(errors='replace')
    for number, line in enumerate(text.splitlines(), 1):
        key = line.partition(':')[0].strip()
        if key != KEY and get_close_matches(key, [KEY], cutoff=0.85):
            return number, key
    return None


def _problems_of_include(
    include: IncludeLaunchDescription, context: LaunchContext, depth: int
) -> Iterator[str]:
    inner = _context('')
    for name, value in include.launch_arguments:
        with contextlib.suppress(Exception):  # a value known only during a launch is left out
            inner.launch_configurations[perform_text(context, name)] = perform_text(context, value)
    try:
        description = include.launch_description_source.get_launch_description(context)
    except Exception as error:
        if isinstance(error, LaunchError) and 'does not exist: declare' in str(error):
            return  # a path that depends on an argument without a default cannot be checked
        yield _line(include.location, error)
        return
    inner.extend_globals(_context(include.launch_description_source.location).get_globals())
    yield from _problems(description, inner, depth + 1)


def _line(location: Location | None, error: Exception) -> str:
    if isinstance(error, LaunchError) and error.located:
        return str(error)
    return f'{location}: {as_sentence(error)}' if location else as_sentence(error)

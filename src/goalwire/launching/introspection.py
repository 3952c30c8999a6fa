"""Looks into a launch description without running it: its arguments, and its tree for printing."""

from __future__ import annotations

from collections.abc import Iterable

from goalwire.launching.actions import DeclareLaunchArgument
from goalwire.launching.model import LaunchDescription, LaunchDescriptionEntity
from goalwire.launching.sources import DEEPEST, IncludeLaunchDescription
from goalwire.launching.values import TextSubstitution


class LaunchIntrospector:
    """Prints launch descriptions as trees."""

    def format_launch_description(self, launch_description: LaunchDescription) -> str:
        """Return the tree of a description as text, one entity a line."""
        return '\n'.join(['LaunchDescription', *_tree(launch_description.entities)])


def _tree(entities: Iterable[LaunchDescriptionEntity]) -> list[str]:
    items = list(entities)
    lines: list[str] = []
    for position, entity in enumerate(items):
        last = position == len(items) - 1
        first, more = ('└── ', '    ') if last else ('├── ', '│   ')
        block = _block(entity)
        lines.append(first + block[0])
        lines += [more + line for line in block[1:]]
    return lines


def _block(entity: LaunchDescriptionEntity) -> list[str]:
    text = 'LaunchDescription' if isinstance(entity, LaunchDescription) else entity.describe()
    condition = getattr(entity, 'condition', None)
    if condition is not None:
        text += f' if {condition.describe()}'
    lines = [text]
    if isinstance(entity, IncludeLaunchDescription):
        inner = entity.read_ahead()
        if inner is not None:
            return lines + _tree(inner.entities)
        missing = entity.launch_description_source.missing
        return [*lines, f'└── not there: {missing}'] if missing else lines
    lines += _tree(entity.describe_sub_entities())
    for when, inner_entities in entity.describe_conditional_sub_entities():
        lines.append(f'└── when {when}:')
        lines += ['    ' + line for line in _tree(inner_entities)]
    return lines


def default_text(argument: DeclareLaunchArgument, *, plain: bool = False) -> str | None:
    """Return an argument's default value as `describe` shows it; None if it has no default.

    With `plain` a default without substitutions is returned without quotes.
    """
    parts = argument.default_value
    if parts is None:
        return None
    if plain and all(isinstance(part, TextSubstitution) for part in parts):
        return ''.join(part.text for part in parts if isinstance(part, TextSubstitution))
    return ' + '.join(part.describe() for part in parts)


def missing_includes(entities: Iterable[LaunchDescriptionEntity], depth: int = 0) -> list[str]:
    """Return why included files could not be read, each reason once, without files that need a launch."""
    found: list[str] = []
    for entity in entities:
        if isinstance(entity, IncludeLaunchDescription):
            inner = entity.read_ahead()
            if entity.launch_description_source.missing:
                found.append(f'{entity.location}: {entity.launch_description_source.missing}')
            elif inner is not None and depth < DEEPEST:
                found += missing_includes(inner.entities, depth + 1)
            continue
        found += missing_includes(entity.describe_sub_entities(), depth)
        for _, inner_entities in entity.describe_conditional_sub_entities():
            found += missing_includes(inner_entities, depth)
    return list(dict.fromkeys(found))


def print_arguments(description: LaunchDescription) -> list[str]:
    """Return the lines of `ros2 launch --show-args`."""
    lines = ["Arguments (pass arguments as '<name>:=<value>'):"]
    arguments = description.get_launch_arguments()
    for argument in arguments:
        star = '*' if argument.conditionally_included else ''
        lines += ['', f"    '{argument.name}':{star}", f'        {argument.description}']
        default = default_text(argument)
        if default is not None:
            lines.append(f'        (default: {default})')
    if not arguments:
        lines += ['', '  No arguments.']
    elif any(argument.conditionally_included for argument in arguments):
        lines += ['', '* argument(s) which are only used if specific conditions occur']
    missing = missing_includes(description.entities)
    if missing:
        lines += ['', 'Passed over, with the arguments in it:', *(f'    {reason}' for reason in missing)]
    return lines

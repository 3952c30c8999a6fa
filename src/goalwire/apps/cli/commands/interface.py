"""ros2 interface: list, show, package, packages, proto."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.stubs import write_stubs_of_packages
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.verbs import Noun, Verb, did_you_mean

if TYPE_CHECKING:
    from collections.abc import Iterator

    from goalwire.apps.cli.framework.output import Output

_TITLES = {'msg': 'Messages', 'srv': 'Services', 'action': 'Actions'}
_FLAGS = {'msg': ('-m', '--only-msgs'), 'srv': ('-s', '--only-srvs'), 'action': ('-a', '--only-actions')}
_SEPARATOR = '---'


def _kind_arguments(parser: ArgumentParser) -> None:
    for kind, flags in _FLAGS.items():
        parser.add_argument(*flags, action='store_true', help=f'Show only {_TITLES[kind].lower()}')


def _kinds(arguments: Namespace) -> list[str]:
    chosen = [kind for kind, (_, flag) in _FLAGS.items() if getattr(arguments, flag[2:].replace('-', '_'))]
    return chosen or list(_FLAGS)


def _list(arguments: Namespace, output: Output) -> None:
    from rosidl_runtime_py import get_interfaces

    found = get_interfaces()
    for kind in _kinds(arguments):
        if not output.json:
            output.line(f'{_TITLES[kind]}:')
        for package in sorted(found):
            for name in sorted(found[package]):
                if name.startswith(f'{kind}/'):
                    output.show(f'{package}/{name}', f'    {package}/{name}')


def _package_arguments(parser: ArgumentParser) -> None:
    parser.add_argument('package_name', help="Name of the package (e.g. 'example_interfaces')")
    _kind_arguments(parser)


def _package(arguments: Namespace, output: Output) -> None:
    from rosidl_runtime_py import get_interface_packages, get_interfaces

    name = arguments.package_name
    try:
        found = get_interfaces([name]).get(name, [])
    except LookupError:
        near = did_you_mean(name, sorted(get_interface_packages())) or 'see: ros2 interface packages'
        raise CommandError(Outcome.NOT_FOUND, f"there is no package '{name}'", near) from None
    if not found:
        raise CommandError(
            Outcome.NOT_FOUND, f"the package '{name}' has no interfaces", 'see: ros2 interface packages'
        )
    for each in sorted(found):
        if each.split('/')[0] in _kinds(arguments):
            output.show(f'{name}/{each}', f'{name}/{each}')


def _packages(arguments: Namespace, output: Output) -> None:
    from rosidl_runtime_py import get_interfaces

    wanted = _kinds(arguments)
    for package, names in sorted(get_interfaces().items()):
        if any(name.split('/')[0] in wanted for name in names):
            output.show(package, package)


# -- show ----------------------------------------------------------------------------------------------------


def _show_arguments(parser: ArgumentParser) -> None:
    comments = parser.add_mutually_exclusive_group()
    comments.add_argument(
        '--all-comments', action='store_true', help='Show comments of nested interfaces, too'
    )
    comments.add_argument('--no-comments', action='store_true', help='Show no comments and no empty lines')
    parser.add_argument(
        'type', help="Type (e.g. 'example_interfaces/msg/String'); - reads it from standard input"
    )


def _show(arguments: Namespace, output: Output) -> None:
    given = sys.stdin.readline(1000).strip() if arguments.type == '-' else arguments.type
    name = any_type_name(given)
    lines = list(_lines(name, comments=not arguments.no_comments, nested=arguments.all_comments, level=0))
    if output.json:
        output.data({'type': name, 'definition': _text(name)})
        return
    output.block('\n'.join(lines), end='\n' if lines else '')


def any_type_name(given: str) -> str:
    """Return 'pkg/kind/Name'; if the user left the kind out, srv, action and msg are tried in this order.

    Raises CommandError if there is no such interface.
    """
    if len(lookup.split_name(given)) != 2:
        return lookup.type_name(given, None)
    for kind in ('srv', 'action'):
        try:
            lookup.interface(name := lookup.type_name(given, kind))
        except CommandError:
            continue
        return name
    lookup.interface(name := lookup.type_name(given, 'msg'))
    return name


def _text(name: str) -> str:
    from goalwire.errors import InterfaceError, UnknownInterfaceError
    from goalwire.idl.registry import definition_text

    try:
        return definition_text(name)
    except UnknownInterfaceError:
        lookup.interface(name)  # raises an error that suggests similar types
        raise
    except InterfaceError as error:
        raise CommandError(Outcome.FAILED, f"the type '{name}' cannot be used: {error}") from None


def _lines(name: str, *, comments: bool, nested: bool, level: int) -> Iterator[str]:
    """Yield the lines of a definition; nested definitions are indented below their fields."""
    package = name.split('/', maxsplit=1)[0]
    for raw in _text(name).splitlines():
        line = raw.rstrip()
        field_type, comment = _parse(line)
        if not comments:
            if not line or line.lstrip().startswith('#'):
                continue
            if field_type and comment:
                line = line[: line.index('#', len(line) - len(comment))].strip()
        yield '\t' * level + line if line else ''
        inner = _find_nested_type(field_type, package)
        if inner is not None:
            yield from _lines(inner, comments=nested, nested=nested, level=level + 1)


def _parse(line: str) -> tuple[str, str]:
    """Return the type of the field on a line, and the line's comment with its #; each is '' if missing."""
    words = line.split('#', maxsplit=1)[0].split()
    if (
        len(words) < 2
        or words[0] == _SEPARATOR
        or '=' in line.split('#', maxsplit=1)[0].split(None, 1)[1].split('"', maxsplit=1)[0]
    ):
        return '', ''  # A constant's comment is always shown, as in ROS 2.
    at = line.find('#')
    is_comment = at >= 0 and '"' not in line[:at] and "'" not in line[:at]
    return words[0], line[at:] if is_comment else ''


def _find_nested_type(field_type: str, package: str) -> str | None:
    from goalwire.idl.model import PRIMITIVES

    base = field_type.partition('[')[0].partition('<')[0]
    if not base or base in PRIMITIVES:
        return None
    if '/' not in base:
        return f'std_msgs/msg/{base}' if base == 'Header' else f'{package}/msg/{base}'
    owner, *_, name = base.split('/')
    return f'{owner}/msg/{name}'


def _proto_arguments(parser: ArgumentParser) -> None:
    parser.add_argument('type', help="Type (e.g. 'std_msgs/msg/String')")
    parser.add_argument('--no-quotes', action='store_true', help='Leave out the quotes around it')


def _proto(arguments: Namespace, output: Output) -> None:
    from rosidl_runtime_py import message_to_yaml

    from goalwire.observe.messages import as_dict

    name = any_type_name(arguments.type)
    cls = lookup.interface(name)
    message = {'srv': 'Request', 'action': 'Goal'}.get(name.split('/')[1])
    instance = (getattr(cls, message) if message else cls)()
    if output.json:
        output.data(as_dict(instance))
        return
    text = message_to_yaml(instance)
    output.block(text if arguments.no_quotes else f'"{text}"')


def _stubs_arguments(parser: ArgumentParser) -> None:
    parser.add_argument('directory', metavar='DIR', help='Where to write, such as typings')
    parser.add_argument(
        'packages', nargs='*', metavar='PACKAGE', help='Packages (default: all that goalwire does not ship)'
    )
    parser.add_argument(
        '--stub-packages',
        dest='plain_names',
        action='store_false',
        help='Name the folders PACKAGE-stubs (PEP 561)',
    )


NOUN = Noun(
    'interface',
    'Show information about ROS interfaces',
    (
        Verb('list', 'List all interface types available', _list, _kind_arguments),
        Verb(
            'package',
            'Output a list of available interface types within one package',
            _package,
            _package_arguments,
        ),
        Verb('packages', 'Output a list of packages that provide interfaces', _packages, _kind_arguments),
        Verb('proto', 'Output an interface prototype', _proto, _proto_arguments),
        Verb('show', 'Output the interface definition', _show, _show_arguments),
        Verb(
            'stubs',
            'The same as goalwire stubs --plain-names --directory DIR',
            write_stubs_of_packages,
            _stubs_arguments,
        ),
    ),
)

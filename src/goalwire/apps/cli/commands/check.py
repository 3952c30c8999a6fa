"""goalwire check: mistakes in interface files and launch files, with file and line."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.idl.model import Field

SUMMARY = 'Check interface files and launch files'
INTERFACES = ('.msg', '.srv', '.action')


def _arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        'paths', nargs='*', default=['.'], help='Files, or folders that contain them (default: this folder)'
    )


def _run(arguments: Namespace, output: Output) -> Outcome:
    problems: list[str] = []
    count = 0
    for path in arguments.paths:
        if not os.path.exists(path):
            raise CommandError(Outcome.NOT_FOUND, f'{arguments.prog}: there is no file or folder {path!r}')
        for file in _files(path):
            count += 1
            problems += check_file(file)
    # Report each problem once: several launch files may include the same file.
    problems = list(dict.fromkeys(problems))
    if not count:
        raise CommandError(
            Outcome.NOT_FOUND,
            f'{arguments.prog}: no interface files and no launch files in {", ".join(arguments.paths)}',
            'name a file or a folder that has some',
        )
    for problem in problems:
        output.show({'problem': problem}, problem)
    if not output.json:
        found = f'{len(problems)} mistake{"s" if len(problems) != 1 else ""}' if problems else 'no mistakes'
        output.line(f'{count} file{"s" if count != 1 else ""} checked: {found}')
    return Outcome.FAILED if problems else Outcome.OK


def _files(path: str) -> Iterator[str]:
    """Yield the file itself, or the files below a folder that can be checked, without build folders."""
    from goalwire.idl.workspace import IGNORE_MARKS, IGNORED
    from goalwire.launching.commands import ENDINGS

    if os.path.isfile(path):
        yield path
        return
    for folder, below, names in os.walk(path):
        if not IGNORE_MARKS.isdisjoint(names):
            below.clear()
            continue
        below[:] = sorted(name for name in below if name[0] != '.' and name not in IGNORED)
        for name in sorted(names):
            if name.endswith(ENDINGS) or (
                name.endswith(INTERFACES) and os.path.basename(folder) == os.path.splitext(name)[1][1:]
            ):
                yield os.path.join(folder, name)


def check_file(path: str) -> list[str]:
    """Yield each problem of one file, as `file:line: text`."""
    if path.endswith(INTERFACES):
        return list(_interface_problems(path))
    from goalwire.launching.checking import check_launch_file

    return check_launch_file(path)


def _interface_problems(path: str) -> Iterator[str]:
    from goalwire.errors import InterfaceError
    from goalwire.idl import grammar, registry
    from goalwire.idl.model import ActionDefinition, MessageDefinition, ServiceDefinition

    folder, file = os.path.split(os.path.abspath(path))
    name, kind = os.path.splitext(file)
    parse = {'.msg': grammar.parse_message, '.srv': grammar.parse_service, '.action': grammar.parse_action}[
        kind
    ]
    package = _package_of(folder)
    try:
        parsed: object = parse(registry.read_definition(path), package, name, source=path)
    except InterfaceError as error:
        yield str(error)
        return
    messages = [parsed] if isinstance(parsed, MessageDefinition) else []
    if isinstance(parsed, ServiceDefinition):
        messages = [parsed.request, parsed.response]
    elif isinstance(parsed, ActionDefinition):
        messages = [parsed.goal, parsed.result, parsed.feedback]
    for message in messages:
        for field in message.fields:
            problem = _unknown_type(field, package, os.path.dirname(folder))
            if problem:
                yield f'{path}:{field.line}: {problem}'


def _unknown_type(field: Field, package: str, folder: str) -> str:
    """Return why a field's message type cannot be found; '' if it exists or the field is not a message."""
    from goalwire.errors import InterfaceError, InterfaceSyntaxError
    from goalwire.idl import registry

    if not field.type.is_message:
        return ''
    owner, kind, name = field.type.base.split('/')
    if owner == package and os.path.isfile(os.path.join(folder, kind, f'{name}.{kind}')):
        return ''
    try:
        registry.message_definition(field.type.base)
    except InterfaceSyntaxError:
        return ''  # The syntax error is reported when the type's own file is checked.
    except InterfaceError as error:
        return ' '.join(str(error).split())
    return ''


def _package_of(folder: str) -> str:
    """Return the package name of a folder of definitions, from package.xml or else from the folder's name."""
    from goalwire.idl.workspace import MANIFEST, package_name

    package = os.path.dirname(folder)
    try:
        return package_name(os.path.join(package, MANIFEST))
    except ValueError:
        return os.path.basename(package) or 'package'


NOUN = Noun('check', SUMMARY, (Verb('check', SUMMARY, _run, _arguments),))

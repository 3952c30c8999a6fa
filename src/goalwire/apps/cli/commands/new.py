"""goalwire new: makes a package that is both a plain Python project and a ROS 2 package (ament_python)."""

from __future__ import annotations

import keyword
import re
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

SUMMARY = 'Make a package: a Python project that colcon builds as well'


_TEMPLATES = Path(__file__).parents[1] / 'templates'
_ENDING = '.template'


class Kind(NamedTuple):
    """A kind of program that a new package may contain."""

    program: str
    """The name of the program's module, and of its folder in `templates`; users run PACKAGE_program."""
    interfaces: str
    """The package that defines the type which the program uses."""
    type_name: str
    own_type: str
    """The file of an equal type that a user's own package of interfaces gets, such as `msg/Greeting.msg`."""
    summary: str


_KINDS = {
    'node': Kind(
        'node',
        'std_msgs',
        'String',
        'msg/Greeting.msg',
        'A node with a topic; without any option, this',
    ),
    'service': Kind('switch_server', 'std_srvs', 'SetBool', 'srv/Switch.srv', 'A service'),
    'action': Kind('count_server', 'example_interfaces', 'Fibonacci', 'action/Count.action', 'An action'),
}


def _arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        'package', help='Name of the package: small letters, digits and underscores, a letter first'
    )
    for name, kind in _KINDS.items():
        parser.add_argument(f'--{name}', action='store_true', help=kind.summary)
    parser.add_argument(
        '--interfaces', action='store_true', help='Make a package of own types as well, PACKAGE_interfaces'
    )
    parser.add_argument(
        '--destination-directory', default='.', help='Where its folder is made (default: here)'
    )


def _run(arguments: Namespace, output: Output) -> None:
    package = arguments.package
    _check_name(arguments.prog, package)
    kinds = [kind for name, kind in _KINDS.items() if getattr(arguments, name)] or [_KINDS['node']]
    place = Path(arguments.destination_directory)
    files = _files(package, kinds, own_types=arguments.interfaces)
    folders = [place / name for name in sorted({name.split('/')[0] for name in files})]
    for folder in folders:
        if folder.exists():
            raise CommandError(
                Outcome.FAILED,
                f'{arguments.prog}: there is a {str(folder)!r} already',
                'choose another name, or another place with --destination-directory',
            )
    for name, text in files.items():
        file = place / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding='utf-8', newline='\n')
    if output.json:
        output.data({'folder': str(folders[0]), 'files': sorted(files)})
        return
    for folder in folders:
        inside = sorted(name.partition('/')[2] for name in files if name.startswith(f'{folder.name}/'))
        output.line(f'made {folder}: {", ".join(inside)}')
    if arguments.interfaces:
        _write_stubs(place / f'{package}_interfaces', output)
    first = '' if str(place) == '.' else f'cd {place}; '
    if find_spec('pytest') is None:
        first += 'pip install pytest; '
    output.line(f'next: {first}python -m pytest {package}; ros2 run {package} {package}_{kinds[0].program}')


def _write_stubs(folder: Path, output: Output) -> None:
    """Write the stubs of a new package of interfaces; if they cannot be written, print what to do."""
    from goalwire.apps.cli.commands.stubs import environment_folder, write_into
    from goalwire.idl import search_path

    search_path.discard()  # the cached search was made before the package existed
    found = search_path.find_package(folder.name)
    if found is not None and found.path.resolve() == folder.resolve():
        found.trusted = True  # because this command has just made the package
        try:
            write_into(environment_folder(), [folder.name], output)
        except CommandError as error:
            output.line(str(error))
    else:
        output.line(f'types for editors: start `goalwire stubs` in {folder.parent}')


def _check_name(prog: str, package: str) -> None:
    """Raise CommandError unless a name is valid for a ROS 2 package (REP 144) and a Python package."""
    if re.fullmatch('[a-z][a-z0-9]*(_[a-z0-9]+)*', package) and not keyword.iskeyword(package):
        return
    wanted = '_'.join(re.findall('[a-z0-9]+', re.sub('(?<=[a-z0-9])(?=[A-Z])', '_', package).lower()))
    wanted = wanted.lstrip('0123456789_')
    advice = f'write {wanted!r}' if wanted and not keyword.iskeyword(wanted) else 'as in my_robot'
    raise CommandError(
        Outcome.BAD_VALUE,
        f'{prog}: {package!r} is not a name of a package: small letters, digits, single underscores',
        advice,
    )


def _files(package: str, kinds: Sequence[Kind], *, own_types: bool) -> dict[str, str]:
    """Return the texts of a new package's files by their paths, its package of interfaces included."""
    interfaces = f'{package}_interfaces'
    scripts = {kind.program: f'{package}_{kind.program}' for kind in kinds}
    used = [interfaces] if own_types else sorted({kind.interfaces for kind in kinds})
    folders = [package, interfaces] if own_types else [package]
    words = {
        'package': package,
        'depends': '\n'.join(f'  <exec_depend>{name}</exec_depend>' for name in used),
        'scripts': '\n'.join(
            f"            '{script} = {package}.{program}:main'," for program, script in scripts.items()
        ),
        'nodes': '\n'.join(
            f"            Node(package='{package}', executable='{script}', parameters=[parameters], "
            "output='screen'),"
            for script in scripts.values()
        ),
        'programs': ', '.join(f'`{script}`' for script in scripts.values()),
        'install': f"pip install -e './{package}[test]'" + (f' -e ./{interfaces}' if own_types else ''),
        'folders': ' and '.join(f'`{name}`' for name in folders),
        'definitions': '\n'.join(f'  "{kind.own_type}"' for kind in kinds),
    }
    files = _fill('package', package, words)
    for kind in kinds:
        program = _fill(f'programs/{kind.program}', package, _words_of(package, kind, alone=len(kinds) == 1))
        files |= {
            name: _with_own_types(text, kind, interfaces) if own_types else text
            for name, text in program.items()
        }
    if own_types:
        files |= _fill('interfaces', interfaces, words)
        for kind in kinds:
            files |= _fill(f'definitions/{kind.program}', interfaces, {})
    return files


def _words_of(package: str, kind: Kind, *, alone: bool) -> dict[str, str]:
    """Return the values for one program's templates.

    The node of a package's only program has the name of the package.
    """
    node = package if alone else f'{package}_{kind.program}'
    class_name = ''.join(map(str.capitalize, node.split('_')))
    return {'package': package, 'node': node, 'Class': class_name, 'program': kind.program}


def _with_own_types(text: str, kind: Kind, interfaces: str) -> str:
    """Return the text of a program or test, with its type replaced by the package's own equal type."""
    return re.sub(
        rf'\b{kind.type_name}\b',
        Path(kind.own_type).stem,
        text.replace(f'from {kind.interfaces}.', f'from {interfaces}.'),
    )


def _fill(folder: str, package: str, words: Mapping[str, str]) -> dict[str, str]:
    """Return the files of a template folder for a package, with each @word@ replaced by its value."""

    def fill(text: str) -> str:
        return re.sub('@([A-Za-z]+)@', lambda found: words[found[1]], text)

    root = _TEMPLATES / folder
    return {
        fill(f'{package}/{file.relative_to(root).as_posix().removesuffix(_ENDING)}'): fill(
            file.read_text(encoding='utf-8')
        )
        for file in sorted(root.rglob(f'*{_ENDING}'))
    }


NOUN = Noun('new', SUMMARY, (Verb('new', SUMMARY, _run, _arguments),))

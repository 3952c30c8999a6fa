"""The implementation of `ros2 launch`: finding launch files, showing their arguments, launching them."""

from __future__ import annotations

import ast
import os
import signal
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path

import goalwire.launching.catalog  # noqa: F401 - it imports what launch files may name
from goalwire.errors import BadLaunchArgumentError, LaunchError, NoLaunchFileError
from goalwire.files import show
from goalwire.launching import packages
from goalwire.launching.introspection import (
    LaunchIntrospector,
    default_text,
    print_arguments,
)
from goalwire.launching.model import LaunchDescription
from goalwire.launching.output import get_logger
from goalwire.launching.service import LaunchService
from goalwire.launching.sources import (
    AnyLaunchDescriptionSource,
    IncludeLaunchDescription,
    get_launch_description_from_any_launch_file,
)
from goalwire.launching.unknown_arguments import unknown_arguments

INTERRUPTED, TERMINATED = 130, 143
"""Exit codes of a launch after Ctrl-C and after another signal: as in shells, 128 plus the number."""
ENDINGS = ('launch.py', 'launch.xml', 'launch.yaml', 'launch.yml', '.launch')


def launch_files(folder: str) -> list[str]:
    """Return the paths of the launch files below a folder, sorted."""
    return sorted(
        os.path.join(place, name)
        for place, _, names in os.walk(folder)
        for name in names
        if name.endswith(ENDINGS)
    )


def file_of_package(package: str, name: str) -> str:
    """Return the path of a package's launch file. Raises LaunchError, which suggests similar names."""
    folder = packages.share(package)
    found = [os.path.join(place, name) for place, _, names in os.walk(folder) if name in names]
    if len(found) == 1:
        return found[0]
    if found:
        raise NoLaunchFileError(
            f"file '{name}' was found more than once in the package '{package}': {', '.join(found)}; "
            'give the path of one of them'
        )
    there = sorted({os.path.basename(path) for path in launch_files(folder)})
    near = get_close_matches(name, there, n=1, cutoff=0.8)
    hint = f'did you mean {near[0]}?' if near else f'it has {", ".join(there) or "no launch files"}'
    raise NoLaunchFileError(
        f"file '{name}' was not found in the package '{package}', which is at '{folder}'; {hint}"
    )


def find_launch_file(words: list[str]) -> tuple[str, list[str]]:
    """Return the file's path and the arguments from `PACKAGE FILE [arguments]` or `PATH [arguments]`."""
    if not words:
        raise NoLaunchFileError('no launch file: ros2 launch PACKAGE FILE, or ros2 launch PATH')
    first, rest = words[0], words[1:]
    named = rest and ':=' not in rest[0]
    if named and not Path(first).is_file():
        return file_of_package(first, rest[0]), rest[1:]
    if Path(first).is_file():
        return first, rest
    if first.endswith(ENDINGS) or os.sep in first:
        raise NoLaunchFileError(f'there is no launch file {show(first)}')
    there = sorted({os.path.basename(path) for path in launch_files(packages.share(first))})
    raise NoLaunchFileError(
        f"which launch file of the package '{first}'? "
        + (f'It has {", ".join(there)}' if there else 'It has none')
    )


def parse_arguments(arguments: Iterable[str]) -> list[tuple[str, str]]:
    """Parse `name:=value` words; the last value of a name counts. Raises LaunchError for other words."""
    found: dict[str, str] = {}
    for argument in arguments:
        name, separator, value = argument.partition(':=')
        if not separator or not name:
            raise BadLaunchArgumentError(
                f"malformed launch argument '{argument}', expected format '<name>:=<value>'"
            )
        found[name] = value
    return list(found.items())


def launch(
    path: str, arguments: Iterable[str] = (), *, debug: bool = False, noninteractive: bool = False
) -> int:
    """Launch a file, wait for its end, and return the exit code: 130 after Ctrl-C, 143 after another signal.

    Raises LaunchError for malformed arguments.
    """
    words = list(arguments)
    given = parse_arguments(words)
    service = LaunchService(argv=words, debug=debug, noninteractive=noninteractive)
    include = IncludeLaunchDescription(AnyLaunchDescriptionSource(path), launch_arguments=given)
    include.location = None
    for sentence in unknown_arguments(path, [name for name, _ in given]):
        get_logger('launch').warning(sentence)
    service.include_launch_description(LaunchDescription([include]))
    code = service.run()
    if code or service.interrupted_by is None:
        return code
    return INTERRUPTED if service.interrupted_by is signal.SIGINT else TERMINATED


def show_arguments(path: str) -> str:
    """Return the text of `ros2 launch --show-args`."""
    return '\n'.join(print_arguments(get_launch_description_from_any_launch_file(path)))


def arguments_as_data(path: str) -> list[dict[str, str | bool | list[str] | None]]:
    """Return the arguments as data; `default` is None if the argument must be given."""
    description = get_launch_description_from_any_launch_file(path)
    return [
        {
            'name': argument.name,
            'description': argument.description,
            'default': default_text(argument, plain=True),
            'choices': argument.choices,
            'conditional': argument.conditionally_included,
        }
        for argument in description.get_launch_arguments()
    ]


def show_description(path: str) -> str:
    """Return the text of `ros2 launch --print`."""
    return LaunchIntrospector().format_launch_description(get_launch_description_from_any_launch_file(path))


def completions(command: str, given: Sequence[str], begun: str) -> list[str]:
    """Return completions of the next word: packages, then launch files or executables, then launch arguments.

    `ros2 launch` offers only packages with launch files. A launch file in Python is read, never run.
    """
    try:
        if not given:
            found = [name for name in packages.names() if name.startswith(begun)]
            return [name for name in found if _has_launch_files(name)] if command == 'launch' else found
        if command == 'run' and len(given) == 1:
            return [os.path.basename(path) for path in packages.executables(given[0])]
        if command != 'launch':
            return []
        if len(given) == 1 and not Path(given[0]).is_file():
            return sorted({os.path.basename(path) for path in launch_files(packages.share(given[0]))})
        path, rest = find_launch_file(list(given))
        known = {argument.partition(':=')[0] for argument in rest}
        return [f'{name}:=' for name in _argument_names(path) if name not in known]
    except LaunchError:
        return []


def _has_launch_files(package: str) -> bool:
    folder = Path(packages.prefix(package))
    share = folder / 'share' / package
    return bool(launch_files(str(share if share.is_dir() else folder)))


def _argument_names(path: str) -> list[str]:
    if not path.endswith('.py'):
        description = get_launch_description_from_any_launch_file(path)
        return [argument.name for argument in description.get_launch_arguments()]
    try:
        tree = ast.parse(Path(path).read_bytes())
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return []
    found = []
    for call in ast.walk(tree):
        if isinstance(call, ast.Call) and ast.unparse(call.func).endswith('DeclareLaunchArgument'):
            named = [each.value for each in call.keywords if each.arg == 'name']
            found += [name.value for name in (call.args[:1] or named) if isinstance(name, ast.Constant)]
    return list(dict.fromkeys(name for name in found if isinstance(name, str)))

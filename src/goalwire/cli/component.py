"""ros2 component: types. goalwire has no containers; what it finds are packages of an ament index."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.cli.outcome import CommandError, Outcome
from goalwire.cli.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.cli.output import Output

_RESOURCE = 'rclcpp_components'


def _types_arguments(parser: ArgumentParser) -> None:
    parser.add_argument('package_name', nargs='?', help='Package to show; all where it is left out')


def _types(arguments: Namespace, output: Output) -> None:
    from ament_index_python.resources import get_resource, get_resources

    found = get_resources(_RESOURCE)
    wanted = arguments.package_name
    if wanted is not None and wanted not in found:
        raise CommandError(
            Outcome.NOT_FOUND, f"the package '{wanted}' has no components", 'see: ros2 component types'
        )
    for package in sorted(found) if wanted is None else [wanted]:
        content, _ = get_resource(_RESOURCE, package)
        names = [line.split(';')[0] for line in content.splitlines() if line.strip()]
        if output.json:
            output.data({'package': package, 'types': names, 'prefix': str(Path(found[package]))})
            continue
        if wanted is None:
            output.line(package)
        for name in names:
            output.line(name if wanted is not None else f'  {name}')


NOUN = Noun(
    'component',
    'Various component related sub-commands',
    (Verb('types', 'Output a list of components registered in the ament index', _types, _types_arguments),),
)

"""ros2 bag list: lists the available storage formats and compressors."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.rosbag2.model import SUFFIXES

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

_STORAGES = {name: f'Files that end with {suffix}' for suffix, name in SUFFIXES.items()}
_ZSTD = {'zstd': 'Files that are compressed when they are closed, or messages one by one'}
PLUGINS = {
    'storage': _STORAGES,
    'converter': {'cdr': 'The only serialization format'},
    'compressor': _ZSTD,
    'decompressor': _ZSTD,
}


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `bag list`."""
    parser.add_argument('plugin_type', choices=list(PLUGINS), help='Which plugins to list')
    parser.add_argument('-v', '--verbose', action='store_true', help='Describe each plugin, too')


def run(arguments: Namespace, output: Output) -> None:
    """Print the names of the plugins."""
    if arguments.verbose and not output.json:
        output.line(f'available {arguments.plugin_type} plugins are:')
    for name, text in PLUGINS[arguments.plugin_type].items():
        if output.json:
            output.data({'name': name, 'description': text})
        elif arguments.verbose:
            output.line(f'name: {name}')
            output.line(f'\t{text}')
        else:
            output.line(name)

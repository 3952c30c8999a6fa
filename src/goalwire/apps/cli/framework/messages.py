"""Messages as text, in the forms of ROS 2's tools."""

from __future__ import annotations

import argparse
from typing import Any

from goalwire.apps.cli.framework.numbers import length

TRUNCATE_LENGTH = 128


def add_style_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the flags that say how messages are shown."""
    parser.add_argument(
        '--csv', action='store_true', help='Print all fields, nested ones too, separated by commas'
    )
    parser.add_argument(
        '-f',
        '--full-length',
        action='store_true',
        help='Print arrays, bytes and strings of any length in full',
    )
    parser.add_argument(
        '-l',
        '--truncate-length',
        type=length,
        default=TRUNCATE_LENGTH,
        metavar='N',
        help=f'Cut arrays, bytes and strings after N elements (default: {TRUNCATE_LENGTH})',
    )
    parser.add_argument('--no-arr', action='store_true', help="Don't print the elements of arrays")
    parser.add_argument('--no-str', action='store_true', help="Don't print the text of strings")
    parser.add_argument('--flow-style', action='store_true', help='Print collections on one line')


def style_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return rosidl_runtime_py's arguments for the flags of `add_style_arguments`."""
    return {
        'truncate_length': None if arguments.full_length else arguments.truncate_length,
        'no_arr': arguments.no_arr,
        'no_str': arguments.no_str,
    }


def as_text(message: Any, arguments: argparse.Namespace) -> str:
    """Return a message as the flags of `add_style_arguments` say."""
    from rosidl_runtime_py import message_to_csv, message_to_yaml

    if arguments.csv:
        return message_to_csv(message, **style_of(arguments))
    return message_to_yaml(message, **style_of(arguments), flow_style=arguments.flow_style)


def message_yaml(fields: Any, *, flow_style: bool = False) -> str:
    """Return a message's fields as YAML: mappings as blocks, and with `flow_style` lists on one line."""
    import sys
    from collections import OrderedDict

    import yaml

    class Dumper(yaml.SafeDumper):
        """Writes an OrderedDict as a mapping in its own order."""

    def represent(dumper: yaml.SafeDumper, data: OrderedDict[str, object]) -> yaml.Node:
        items = [(dumper.represent_data(key), dumper.represent_data(item)) for key, item in data.items()]
        return yaml.MappingNode('tag:yaml.org,2002:map', items)

    Dumper.add_representer(OrderedDict, represent)
    text: str = yaml.dump(
        fields, Dumper=Dumper, allow_unicode=True, width=sys.maxsize, default_flow_style=flow_style
    )
    return text

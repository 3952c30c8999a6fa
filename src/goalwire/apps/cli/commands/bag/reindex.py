"""ros2 bag reindex: write the metadata of a bag anew."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.bag.rewriting import reindex
from goalwire.apps.cli.commands.bag.reading import bag_argument
from goalwire.apps.cli.framework.output import tell

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `bag reindex`."""
    bag_argument(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Write the metadata, and print the bag's content."""
    with reindex(arguments.bag_path) as bag:
        for problem in bag.problems:
            tell(problem)
        output.line(f'{bag.facts.count:,} messages in {len(bag.facts.files)} files')

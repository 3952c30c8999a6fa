"""ros2 bag repair: save the readable part of a broken bag."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.bag.rewriting import repair
from goalwire.apps.cli.commands.bag.reading import bag_argument
from goalwire.apps.cli.framework.output import tell
from goalwire.rosbag2.reader import Reader, stored_files
from goalwire.rosbag2.writer import Writer

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `bag repair`."""
    bag_argument(parser)
    parser.add_argument('-o', '--output', metavar='FOLDER', required=True, help='Folder to make')


def run(arguments: Namespace, output: Output) -> None:
    """Write the new bag; the old one stays as it is."""
    path = arguments.bag_path
    # The files are listed from the folder, because the metadata may be broken.
    files = stored_files(path) if Path(path).is_dir() else ()
    with Reader(path, files=files) as bag, Writer(arguments.output, storage=bag.facts.storage) as target:
        for problem in bag.check():
            tell(problem)
        count = repair(bag, target)
        output.line(f"'{target.path}' has the {count:,} messages that can be read")

"""ros2 bag: its verbs; each is imported when it is run."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from importlib import import_module
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.outcome import Outcome
    from goalwire.apps.cli.framework.output import Output


def _verb(name: str, summary: str, *, has_json: bool = False) -> Verb:
    """Return the verb of a module beside this one, which has `add_arguments` and `run`."""

    def run(arguments: Namespace, output: Output) -> Outcome | None:
        outcome: Outcome | None = import_module(f'{__package__}.{name}').run(arguments, output)
        return outcome

    def add_arguments(parser: ArgumentParser) -> None:
        import_module(f'{__package__}.{name}').add_arguments(parser)

    return Verb(name, summary, run, add_arguments, has_json=has_json)


NOUN = Noun(
    'bag',
    'Various rosbag related commands',
    (
        _verb('burst', 'Burst data from a bag'),
        _verb('check', 'Read every byte of a bag, and say what is wrong with it'),
        _verb('convert', 'Given an input bag, write out a new bag with different settings'),
        _verb('export', 'Write the messages of a bag as CSV or JSON lines'),
        _verb('info', 'Print information about a bag to the screen', has_json=True),
        _verb('list', 'Print information about available plugins to the screen', has_json=True),
        _verb('play', 'Play back ROS data from a bag'),
        _verb('record', 'Record ROS data to a bag'),
        _verb('reindex', 'Reconstruct metadata file for a bag'),
        _verb('repair', 'Write whatever can be read of a bag into a new one'),
    ),
)

"""ros2 bag play --expect and --answer-calls: compares a bag with live servers, or answers in their place."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, Namespace
from contextlib import suppress
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.numbers import length, positive
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.output import tell

if TYPE_CHECKING:
    import goalwire
    from goalwire.apps.bag.selection import Selection
    from goalwire.apps.cli.framework.output import Output
    from goalwire.rosbag2.reader import Reader

NODE_NAME = 'rosbag2_player'
ANSWER_S = 10.0


def add_live_arguments(parser: ArgumentParser) -> None:
    """Add the flags --answer-calls and --expect."""
    group = parser.add_argument_group('calls and goals')
    both = group.add_mutually_exclusive_group()
    both.add_argument(
        '--expect',
        action='store_true',
        help='Send the recorded requests and goals, publish nothing, and compare the answers with the '
        'recorded ones; the exit code is 1 if they differ',
    )
    both.add_argument(
        '--answer-calls',
        action='store_true',
        help='Serve the recorded services and actions with the recorded answers, until Ctrl-C',
    )
    group.add_argument(
        '--tolerance',
        metavar='X',
        type=positive,
        default=0.0,
        help='With --expect: how far floating-point fields may be apart (default: not at all)',
    )
    group.add_argument(
        '--feedback-tolerance',
        metavar='N',
        type=length,
        default=0,
        help='With --expect: by how many the counts of feedback messages may differ (default: 0)',
    )
    group.add_argument('--ignore-stamps', action='store_true', help='With --expect: times may differ')
    group.add_argument(
        '--ignore-fields',
        metavar='FIELD',
        nargs='+',
        default=[],
        help="With --expect: fields that may differ, by name or as 'result.pose.*'",
    )
    group.add_argument(
        '--answer-timeout',
        metavar='S',
        type=positive,
        default=ANSWER_S,
        help=f'With --expect: how long an answer may take, and a goal beyond its recorded time '
        f'(default: {ANSWER_S:g})',
    )


def expect(bag: Reader, selection: Selection, arguments: Namespace, output: Output) -> Outcome:
    """Send the recorded requests and goals, and print the answers that differ; FAILED if any do."""
    from goalwire.apps.bag.live_comparison import Replay, ReplayOptions
    from goalwire.apps.bag.message_comparison import Tolerance
    from goalwire.apps.cli.framework.live import live

    options = ReplayOptions(
        selection=selection,
        tolerance=Tolerance(
            number=arguments.tolerance,
            feedback=arguments.feedback_tolerance,
            stamps=arguments.ignore_stamps,
            fields=tuple(arguments.ignore_fields),
        ),
        rate=arguments.rate,
        timeout=arguments.answer_timeout,
    )

    async def compare(node: goalwire.Node) -> Outcome:
        replay = Replay(node, bag, options)
        tell(f"sending {replay.calls:,} requests and {replay.goals:,} goals of '{bag.path}'")
        differences = await replay.run()
        for difference in differences:
            output.line(str(difference))
        tell(f'{len(differences):,} differences' if differences else 'everything is as it was recorded')
        return Outcome.FAILED if differences else Outcome.OK

    return live(compare, NODE_NAME)


def answer(bag: Reader, selection: Selection, arguments: Namespace) -> Outcome:
    """Serve the recorded answers until Ctrl-C."""
    from goalwire.apps.bag.answering import Answers
    from goalwire.apps.cli.framework.live import live

    async def serve(node: goalwire.Node) -> Outcome:
        answers = Answers(node, bag, selection, rate=arguments.rate)
        tell(f"answering from '{bag.path}': {', '.join(answers.names)}; Ctrl-C ends it")
        # A signal such as Ctrl-C cancels the wait. This is the normal end of the command.
        with suppress(asyncio.CancelledError):
            await asyncio.Event().wait()
        tell(f'{answers.answered:,} requests and goals were answered')
        return Outcome.OK

    return live(serve, NODE_NAME)

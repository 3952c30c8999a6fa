"""ros2 topic hz: measures how often messages arrive."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.commands.topic.rates import Window, report, spread_text
from goalwire.apps.cli.commands.topic.reading import RawSource, Source, raw_source, source, window_argument
from goalwire.apps.cli.framework.discovery import add_graph_arguments
from goalwire.apps.cli.framework.expressions import Expression
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.outcome import Outcome

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

WINDOW = 10_000


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `topic hz`."""
    parser.add_argument(
        'topic_names', nargs='+', metavar='topic_name', help="Names of topics (e.g. '/chatter')"
    )
    add_graph_arguments(parser)
    window_argument(parser, WINDOW)
    parser.add_argument(
        '--filter', metavar='EXPR', help='Count only messages m for which this Python expression is true'
    )
    parser.add_argument(
        '--wall-time', action='store_true', help='Use the wall clock even with --use-sim-time'
    )


async def _count(
    node: goalwire.Node, topic: Source | RawSource, arguments: Namespace, output: Output
) -> None:
    wanted = Expression(arguments.filter) if arguments.filter else None
    subscription: goalwire.Subscription[Any] = (
        node.subscription(topic.cls, topic.name, qos=topic.qos)
        if isinstance(topic, Source)
        else node.subscription(topic.type, topic.name, qos=topic.qos, raw=True)
    )
    by_clock = arguments.use_sim_time and not arguments.wall_time
    window = Window(arguments.window)
    last: float | None = None

    def note(message: Any) -> bool:
        nonlocal last
        if wanted is not None and not wanted(message):
            return False
        assert subscription.info is not None
        now = (node.clock.now().nanoseconds if by_clock else subscription.info['received_timestamp']) / 1e9
        if last is not None and now >= last:
            window.values.append(now - last)
        last = now
        return bool(window.values)

    def show() -> None:
        spread = window.spread()
        rate = 1.0 / spread.mean if spread.mean else 0.0
        if output.json:
            output.data({'name': topic.name, 'rate': rate, **spread._asdict()})
            return
        if len(arguments.topic_names) > 1:
            output.line(f'[{topic.name}]')
        output.block(spread_text('rate', rate, spread))

    await report(subscription, note, show)


def run(arguments: Namespace, output: Output) -> Outcome:
    """Print rates until Ctrl-C. Messages are decoded only for a filter, which needs their definition."""
    if arguments.filter:
        Expression(arguments.filter)  # report a bad expression before anything is opened
    find = source if arguments.filter else raw_source
    topics = [find(arguments, name) for name in arguments.topic_names]

    async def follow(node: goalwire.Node) -> None:
        async with asyncio.TaskGroup() as group:
            for topic in topics:
                group.create_task(_count(node, topic, arguments, output))

    return live(follow, use_sim_time=arguments.use_sim_time)

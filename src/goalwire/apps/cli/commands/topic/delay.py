"""ros2 topic delay: how old messages are when they come, by the stamp in their header."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.commands.topic.rates import Window, report, spread_text
from goalwire.apps.cli.commands.topic.reading import source, window_argument
from goalwire.apps.cli.framework.discovery import add_graph_arguments
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.outcome import CommandError, Outcome

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

WINDOW = 10_000


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `topic delay`."""
    parser.add_argument('topic_name', help="Name of the topic (e.g. '/chatter')")
    add_graph_arguments(parser)
    window_argument(parser, WINDOW)


def run(arguments: Namespace, output: Output) -> Outcome:
    """Print the delay until Ctrl-C."""
    topic = source(arguments, arguments.topic_name)
    if topic.cls.get_fields_and_field_types().get('header') != 'std_msgs/Header':
        raise CommandError(
            Outcome.BAD_VALUE,
            f"the messages of '{topic.name}' have no header",
            'see: ros2 topic hz, for the rate',
        )

    window = Window(arguments.window)

    def show() -> None:
        spread = window.spread()
        if output.json:
            output.data({'name': topic.name, **spread._asdict()})
        else:
            output.block(spread_text('delay', spread.mean, spread))

    async def follow(node: goalwire.Node) -> None:
        def note(message: Any) -> bool:
            stamp = message.header.stamp
            window.values.append(node.clock.now().nanoseconds / 1e9 - stamp.sec - stamp.nanosec / 1e9)
            return True

        await report(node.subscription(topic.cls, topic.name, qos=topic.qos), note, show)

    return live(follow, use_sim_time=arguments.use_sim_time)

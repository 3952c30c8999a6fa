"""ros2 topic bw: measures how many bytes a topic's messages have in a second."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections import deque
from time import monotonic
from typing import TYPE_CHECKING

import goalwire
from goalwire.apps.cli.commands.topic.rates import Window, bandwidth_text, report
from goalwire.apps.cli.commands.topic.reading import raw_source, window_argument
from goalwire.apps.cli.framework.discovery import add_graph_arguments
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.outcome import Outcome

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

WINDOW = 100


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `topic bw`."""
    parser.add_argument('topic_name', help="Name of the topic (e.g. '/chatter')")
    add_graph_arguments(parser)
    window_argument(parser, WINDOW)


def run(arguments: Namespace, output: Output) -> Outcome:
    """Print the bandwidth until Ctrl-C."""
    topic = raw_source(arguments, arguments.topic_name)
    sizes, times = Window(arguments.window), deque[float](maxlen=arguments.window)

    def note(payload: bytes) -> bool:
        sizes.values.append(len(payload))
        times.append(monotonic())
        return len(times) > 1

    def show() -> None:
        spread, rate = sizes.spread(), sum(sizes.values) / (times[-1] - times[0])
        if output.json:
            output.data({'name': topic.name, 'bytes_per_second': rate, **spread._asdict()})
        else:
            output.block(bandwidth_text(rate, spread))

    async def follow(node: goalwire.Node) -> None:
        if not output.json:
            output.block(f'Subscribed to [{topic.name}]')
        await report(node.subscription(topic.type, topic.name, qos=topic.qos, raw=True), note, show)

    return live(follow, use_sim_time=arguments.use_sim_time)

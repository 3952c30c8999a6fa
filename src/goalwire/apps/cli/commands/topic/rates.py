"""ros2 topic bw, delay and hz: how much and how often a topic sends, and how old its messages are."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, Namespace
from collections import deque
from collections.abc import AsyncIterable, Callable
from math import sqrt
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import goalwire
from goalwire.apps.cli.commands.topic.reading import RawSource, Source, raw_source, source, window_argument
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.discovery import add_graph_arguments
from goalwire.apps.cli.framework.expressions import Expression
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.observe.headers import stamp_of_first_field

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


T = TypeVar('T')

EVERY_S = 1.0
"""Seconds between two lines of figures, as in ROS 2."""
_BANDWIDTH_WINDOW = 100
_WINDOW = 10_000
"""How many messages the figures are about, as in ROS 2."""


def add_measure_bandwidth_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `topic bw`."""
    parser.add_argument('topic_name', help="Name of the topic (e.g. '/chatter')")
    add_graph_arguments(parser)
    window_argument(parser, _BANDWIDTH_WINDOW)


def measure_bandwidth(arguments: Namespace, output: Output) -> Outcome:
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


def add_measure_delay_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `topic delay`."""
    parser.add_argument('topic_name', help="Name of the topic (e.g. '/chatter')")
    add_graph_arguments(parser)
    window_argument(parser, _WINDOW)


def measure_delay(arguments: Namespace, output: Output) -> Outcome:
    """Print the delay until Ctrl-C.

    If neither this machine nor any node knows the type, its first field is read as a header.
    """
    topic = raw_source(arguments, arguments.topic_name)
    cls = _class_of(topic.type.type_name)
    if cls is not None and cls.get_fields_and_field_types().get('header') != 'std_msgs/Header':
        raise _without_header(topic.name)
    window = Window(arguments.window)

    def show() -> None:
        spread = window.spread()
        if output.json:
            output.data({'name': topic.name, **spread._asdict()})
        else:
            output.block(spread_text('delay', spread.mean, spread))

    async def follow(node: goalwire.Node) -> None:
        def note(message: Any) -> bool:
            stamp = stamp_of_first_field(message) if cls is None else _stamp(message)
            if stamp is None:
                raise _without_header(topic.name)
            window.values.append(node.clock.now().nanoseconds / 1e9 - stamp)
            return True

        subscription: goalwire.Subscription[Any] = (
            node.subscription(topic.type, topic.name, qos=topic.qos, raw=True)
            if cls is None
            else node.subscription(cls, topic.name, qos=topic.qos)
        )
        await report(subscription, note, show)

    return live(follow, use_sim_time=arguments.use_sim_time)


def _class_of(type_name: str) -> Any:
    """Return the class of a type; print a note and return None if the type is unknown."""
    try:
        return lookup.interface_in_use(type_name)
    except CommandError as error:
        if error.outcome is not Outcome.NOT_FOUND:
            raise
    tell(f"the type '{type_name}' is not known here: its first field is taken for the header")
    return None


def _stamp(message: Any) -> float:
    stamp = message.header.stamp
    return float(stamp.sec + stamp.nanosec / 1e9)


def _without_header(topic: str) -> CommandError:
    return CommandError(
        Outcome.BAD_VALUE, f"the messages of '{topic}' have no header", 'see: ros2 topic hz, for the rate'
    )


def add_measure_rate_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `topic hz`."""
    parser.add_argument(
        'topic_names', nargs='+', metavar='topic_name', help="Names of topics (e.g. '/chatter')"
    )
    add_graph_arguments(parser)
    window_argument(parser, _WINDOW)
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


def measure_rate(arguments: Namespace, output: Output) -> Outcome:
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


async def report(messages: AsyncIterable[T], note: Callable[[T], bool], show: Callable[[], None]) -> None:
    """Call `note` with each message, and `show` once a second to print the figures.

    `note` returns False if the message does not count, or if there are too few messages for a figure.
    """
    shown = monotonic()
    async for message in messages:
        if note(message) and monotonic() >= shown + EVERY_S:
            shown = monotonic()
            show()


class Spread(NamedTuple):
    """Mean, extremes and standard deviation of some values."""

    mean: float
    least: float
    most: float
    deviation: float
    number: int


class Window:
    """The latest `size` measured values, of which `spread` gives the mean."""

    def __init__(self, size: int) -> None:
        self.values: deque[float] = deque(maxlen=size)

    def spread(self) -> Spread:
        """Return mean, extremes and standard deviation; needs at least one value."""
        n = len(self.values)
        mean = sum(self.values) / n
        deviation = sqrt(sum((each - mean) ** 2 for each in self.values) / n)
        return Spread(mean, min(self.values), max(self.values), deviation, n)


def spread_text(title: str, mean: float, spread: Spread) -> str:
    """Return ROS 2's two lines about times in s."""
    return (
        f'average {title}: {mean:.3f}\n\tmin: {spread.least:.3f}s max: {spread.most:.3f}s '
        f'std dev: {spread.deviation:.5f}s window: {spread.number}'
    )


def bandwidth_text(bytes_a_second: float, sizes: Spread) -> str:
    """Return ROS 2's two lines about bytes, in a unit that suits the rate."""
    power, unit = (0, 'B') if bytes_a_second < 1e3 else (1, 'KB') if bytes_a_second < 1e6 else (2, 'MB')

    def show_size(number: float) -> str:
        return f'{number:.0f} B' if not power else f'{number / 1000**power:.2f} {unit}'

    return (
        f'{show_size(bytes_a_second)}/s from {sizes.number} messages\n'
        f'\tMessage size mean: {show_size(sizes.mean)} min: {show_size(sizes.least)} '
        f'max: {show_size(sizes.most)}'
    )

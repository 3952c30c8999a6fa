"""ros2 topic delay: measures the age of arriving messages by the stamp in their header."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.commands.topic.rates import Window, report, spread_text
from goalwire.apps.cli.commands.topic.reading import raw_source, window_argument
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.discovery import add_graph_arguments
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.observe.headers import stamp_of_first_field

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

WINDOW = 10_000


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `topic delay`."""
    parser.add_argument('topic_name', help="Name of the topic (e.g. '/chatter')")
    add_graph_arguments(parser)
    window_argument(parser, WINDOW)


def run(arguments: Namespace, output: Output) -> Outcome:
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

"""ros2 topic echo: messages as they come."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.commands.topic.reading import source
from goalwire.apps.cli.framework.discovery import add_graph_arguments
from goalwire.apps.cli.framework.expressions import Expression
from goalwire.apps.cli.framework.fields import field_path, field_value
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.messages import add_style_arguments, as_text
from goalwire.apps.cli.framework.numbers import positive
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.qos import add_qos_arguments
from goalwire.observe.messages import as_dict, plain

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `topic echo`."""
    parser.add_argument('topic_name', help="Name of the topic (e.g. '/chatter')")
    parser.add_argument('message_type', nargs='?', help='Type of the messages, if the graph does not know it')
    add_graph_arguments(parser)
    add_qos_arguments(parser, 'subscribe', 'what suits the publishers')
    add_style_arguments(parser)
    parser.add_argument(
        '--field', metavar='FIELD', help="Print one field only (e.g. 'pose.position.x', 'ranges[0]')"
    )
    parser.add_argument('--raw', action='store_true', help='Print the serialized bytes')
    parser.add_argument(
        '--filter',
        metavar='EXPR',
        help='Print only if this Python expression of m is true; m is the message, or the field of --field',
    )
    parser.add_argument('--once', action='store_true', help='Print the first message and exit')
    parser.add_argument('--timeout', metavar='S', type=positive, help='Exit after that many seconds')
    parser.add_argument(
        '-i', '--include-message-info', action='store_true', help='Print when each message came, too'
    )
    parser.add_argument('-c', '--clear', action='store_true', help='Clear the terminal before each message')
    parser.add_argument('-n', '--node-name', metavar='NAME', help='Name of the node that subscribes')
    parser.add_argument(
        '--no-lost-messages',
        action='store_true',
        help='Accepted as in ROS 2: lost messages are not reported here',
    )


_TOLD = (
    'source_timestamp',
    'received_timestamp',
    'publication_sequence_number',
    'reception_sequence_number',
)
"""The fields of a message's info that ROS 2 Jazzy's command prints, in its order."""


class _Printer:
    """Prints messages in the form that the command's options choose."""

    def __init__(self, arguments: Namespace, output: Output) -> None:
        self._arguments = arguments
        self._output = output
        self._filter = Expression(arguments.filter) if arguments.filter else None
        self._path = field_path(arguments.field) if arguments.field else []

    def show(self, message: Any, info: Any) -> bool:
        """Print a message; return False if the filter excludes it."""
        arguments, output = self._arguments, self._output
        value = field_value(message, self._path, arguments.field)
        if self._filter is not None and not self._filter(value):
            return False
        about: dict[str, int | None] = {name: info[name] for name in _TOLD}
        if output.json:
            told = value.hex() if arguments.raw else as_dict(value)
            output.data({'info': about, 'message': told} if arguments.include_message_info else told)
            return True
        if arguments.clear and output.is_terminal:
            output.raw('\x1b[2J\x1b[H')
        output.block(self._text(value, about if arguments.include_message_info else None))
        return True

    def _text(self, value: Any, about: dict[str, int | None] | None) -> str:
        """Return a message or a single value as ROS 2 prints it, after the message info `about`."""
        arguments = self._arguments
        if not hasattr(value, 'get_fields_and_field_types'):
            before = (
                ''
                if about is None
                else f'---Got new message, message info:---\n{about}\n---Message data:---\n'
            )
            return before + (repr(value) if arguments.raw else str(plain(value))) + '\n---'
        if arguments.csv:
            before = '' if about is None else ','.join(map(str, about.values())) + ','
            return before + as_text(value, arguments)
        lines = [
            f'{name}: {"null" if number is None else number}\n'
            for name, number in sorted((about or {}).items())
        ]
        return ''.join(lines) + ('---\n' if lines else '') + as_text(value, arguments) + '---'


def run(arguments: Namespace, output: Output) -> Outcome:
    """Print messages until Ctrl-C, the first message with --once, or the timeout."""
    printer = _Printer(arguments, output)
    topic = source(arguments, arguments.topic_name, arguments.message_type)

    async def follow(node: goalwire.Node) -> Outcome:
        subscription: goalwire.Subscription[Any] = (
            node.subscription(topic.cls, topic.name, qos=topic.qos, raw=True)
            if arguments.raw
            else node.subscription(topic.cls, topic.name, qos=topic.qos)
        )
        seen = False
        try:
            async with asyncio.timeout(arguments.timeout):
                async for message in subscription:
                    shown = printer.show(message, subscription.info)
                    seen = seen or shown
                    if shown and arguments.once:
                        break
        except TimeoutError:
            if not seen:
                raise CommandError(
                    Outcome.TIMEOUT,
                    f"no message came on '{topic.name}' within {arguments.timeout} s",
                    f'see: ros2 topic info -v {topic.name}',
                ) from None
        return Outcome.OK

    return live(follow, arguments.node_name, use_sim_time=arguments.use_sim_time)

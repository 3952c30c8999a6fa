"""ros2 topic pub: publishes one message, again and again."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, Namespace
from time import monotonic
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.commands.service.call import LOOK_S
from goalwire.apps.cli.framework import lookup, values
from goalwire.apps.cli.framework.discovery import add_graph_arguments
from goalwire.apps.cli.framework.entity_kinds import TOPICS
from goalwire.apps.cli.framework.live import live, refuse_other_type, tell_types_ourselves, types_there
from goalwire.apps.cli.framework.numbers import length, positive, seconds
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.qos import add_qos_arguments, choose_qos
from goalwire.observe.messages import as_dict
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

KEEP_ALIVE_S = 0.1


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `topic pub`."""
    parser.add_argument('topic_name', help="Name of the topic (e.g. '/chatter')")
    parser.add_argument(
        'words',
        nargs='*',
        metavar='[TYPE] [VALUES]',
        help=f'Type of the message, which may be left out if the graph knows it; then {values.HELP}',
    )
    add_graph_arguments(parser)
    parser.add_argument('--stdin', action='store_true', help='Read the values from standard input')
    parser.add_argument(
        '-r', '--rate', metavar='N', type=positive, default=1.0, help='Messages a second (default: 1)'
    )
    parser.add_argument(
        '-p', '--print', metavar='N', type=length, default=1, help='Print every N-th message (default: 1)'
    )
    times = parser.add_mutually_exclusive_group()
    times.add_argument('-1', '--once', action='store_true', help='Publish one message and exit')
    times.add_argument(
        '-t', '--times', metavar='N', type=length, default=0, help='Publish N messages and exit'
    )
    parser.add_argument(
        '-w',
        '--wait-matching-subscriptions',
        metavar='N',
        type=length,
        help='Wait until N subscriptions match (default: 1 with --once and --times, else 0)',
    )
    parser.add_argument(
        '--max-wait-time-secs', metavar='S', type=positive, help='Seconds to wait for them at most'
    )
    parser.add_argument(
        '--keep-alive',
        metavar='S',
        type=seconds,
        default=KEEP_ALIVE_S,
        help=f'Seconds to stay after the last message (default: {KEEP_ALIVE_S})',
    )
    parser.add_argument('-n', '--node-name', metavar='NAME', help='Name of the node that publishes')
    add_qos_arguments(parser, 'publish', 'default')


class _Publication:
    """A message to publish, and how often."""

    def __init__(self, arguments: Namespace, output: Output) -> None:
        """Read the command line; raises CommandError."""
        self._arguments = arguments
        self._output = output
        self._name = lookup.full_name(arguments.topic_name, 'topic')
        type_name, words = lookup.split_type(arguments.words, 'msg')
        if type_name is None:
            _, type_name = TOPICS.name_and_type(arguments)
        self._type_name = type_name
        self._cls = lookup.interface_in_use(type_name)
        self._message: Any = self._cls()
        given = values.read_values(words, self._cls, stdin=arguments.stdin)
        self._stamps = values.fill(self._message, given, type_name)
        self._times = 1 if arguments.once else arguments.times
        wanted = arguments.wait_matching_subscriptions
        self._wanted: int = (1 if self._times else 0) if wanted is None else wanted

    async def perform(self, node: goalwire.Node) -> None:
        arguments, output = self._arguments, self._output
        if self._wanted:
            tell_types_ourselves()
        publisher = node.publisher(self._cls, self._name, qos=choose_qos(arguments, goalwire.QoS()))
        if self._wanted:
            await self._wait(publisher, node)
        if not output.json:
            output.block('publisher: beginning loop')
        number, start = 0, monotonic()
        while not self._times or number < self._times:
            number += 1
            for set_stamp in self._stamps:
                set_stamp(node.clock.now().to_msg())
            publisher.publish(self._message)
            if arguments.print and number % arguments.print == 0:
                self._print(number)
            if number != self._times:
                await asyncio.sleep(max(0.0, start + number / arguments.rate - monotonic()))
        await asyncio.sleep(max(0.0, arguments.keep_alive))

    def _print(self, number: int) -> None:
        if self._output.json:
            self._output.data({'number': number, 'message': as_dict(self._message)})
        else:
            self._output.block(f'publishing #{number}: {self._message!r}\n')

    async def _wait_a_moment(self, publisher: goalwire.Publisher[Any], node: goalwire.Node) -> None:
        """Wait for subscriptions, LOOK_S at most; raises CommandError if all of them have another type."""
        try:
            await publisher.wait_for_subscribers(self._wanted, timeout=LOOK_S)
        except goalwire.DeadlineError:
            there = types_there(node, EndpointKind.SUBSCRIPTION, self._name)
            refuse_other_type(self._name, self._type_name, there)

    async def _wait(self, publisher: goalwire.Publisher[Any], node: goalwire.Node) -> None:
        limit = self._arguments.max_wait_time_secs
        if publisher.subscribers() < self._wanted and not self._output.json:
            self._output.block(f'Waiting for at least {self._wanted} matching subscription(s)...')
        try:
            await self._wait_a_moment(publisher, node)
            await publisher.wait_for_subscribers(self._wanted, timeout=limit)
        except goalwire.DeadlineError:
            raise CommandError(
                Outcome.TIMEOUT,
                f'Timed out waiting for subscribers: Expected {self._wanted} subscribers but only got '
                f'{publisher.subscribers()} subscribers',
                f'see: ros2 topic info -v {self._name}',
            ) from None


def run(arguments: Namespace, output: Output) -> Outcome:
    """Publish until Ctrl-C, or as many messages as --times says."""
    publication = _Publication(arguments, output)
    return live(publication.perform, arguments.node_name, use_sim_time=arguments.use_sim_time)

"""ros2 topic: list, info, type, find, pub, echo, hz, bw, delay."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.discovery import discovered
from goalwire.apps.cli.framework.entity_kinds import TOPICS
from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def _list_arguments(parser: ArgumentParser) -> None:
    TOPICS.list_arguments(parser)
    TOPICS.add_hidden_flag(parser, '-a', '--all')
    parser.add_argument('-v', '--verbose', action='store_true', help='Show how many publish and subscribe')


def _list(arguments: Namespace, output: Output) -> None:
    if arguments.count or not (arguments.verbose or output.json):
        TOPICS.print_all(arguments, output)
        return
    from goalwire.transport.contract import EndpointKind

    with discovered(arguments) as graph:
        found = TOPICS.names(graph, arguments)
    counts = {
        name: (graph.count(EndpointKind.PUBLISHER, name), graph.count(EndpointKind.SUBSCRIPTION, name))
        for name, _ in found
    }
    if output.json:
        for name, types in found:
            publishers, subscribers = counts[name]
            output.data({'name': name, 'types': types, 'publishers': publishers, 'subscribers': subscribers})
        return
    for at, (title, noun) in enumerate((('Published', 'publisher'), ('Subscribed', 'subscriber'))):
        output.line(f'{title} topics:')
        for name, types in found:
            if n := counts[name][at]:
                output.line(f' * {name} [{", ".join(types)}] {n} {noun}{"s" if n > 1 else ""}')
        output.line()


def _find_arguments(parser: ArgumentParser) -> None:
    TOPICS.find_arguments(parser)
    TOPICS.add_hidden_flag(parser)


def _info_arguments(parser: ArgumentParser) -> None:
    TOPICS.name_argument(parser)
    parser.add_argument('-v', '--verbose', action='store_true', help='Show nodes, type hashes and QoS, too')


def _info(arguments: Namespace, output: Output) -> None:
    from goalwire.apps.cli.framework.endpoints import as_json, as_text
    from goalwire.transport.contract import EndpointKind

    name, types, graph = TOPICS.one(arguments, whole=True)
    publishers = graph.entities(EndpointKind.PUBLISHER, name)
    subscribers = graph.entities(EndpointKind.SUBSCRIPTION, name)
    if output.json:
        groups = {
            'publishers': list(map(as_json, publishers)),
            'subscribers': list(map(as_json, subscribers)),
        }
        output.data({'name': name, 'types': types, **groups})
        return
    end = '\n\n' if arguments.verbose else '\n'
    output.block(f'Type: {types[0] if len(types) == 1 else types}', end=end)
    for title, endpoints in (('Publisher', publishers), ('Subscription', subscribers)):
        output.block(f'{title} count: {len(endpoints)}', end=end)
        for each in endpoints if arguments.verbose else ():
            output.block(as_text(each), end=end)


NOUN = Noun(
    'topic',
    'Various topic related sub-commands',
    (
        Verb('bw', 'Display bandwidth used by topic', *lazy('topic.rates', 'measure_bandwidth')),
        Verb(
            'delay', 'Display delay of topic from timestamp in header', *lazy('topic.rates', 'measure_delay')
        ),
        Verb('echo', 'Output messages from a topic', *lazy('topic.echo')),
        Verb(
            'find', 'Output a list of available topics of a given type', TOPICS.print_of_type, _find_arguments
        ),
        Verb('hz', 'Print the average receiving rate to screen', *lazy('topic.rates', 'measure_rate')),
        Verb('info', 'Print information about a topic', _info, _info_arguments),
        Verb('list', 'Output a list of available topics', _list, _list_arguments),
        Verb('plot', 'Draw fields of messages in the terminal', *lazy('topic.plot'), has_json=False),
        Verb('pub', 'Publish a message to a topic', *lazy('topic.pub')),
        Verb('type', "Print a topic's type", TOPICS.print_types, TOPICS.name_argument),
    ),
    TOPICS.noun_arguments,
)

"""ros2 topic: list, info, type, find, pub, echo, hz, bw, delay."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from importlib import import_module
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.discovery import discovered
from goalwire.apps.cli.framework.named import TOPICS
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.verbs import AddArguments, Noun, Run, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def _list_arguments(parser: ArgumentParser) -> None:
    TOPICS.list_arguments(parser)
    TOPICS.hidden_flag(parser, '-a', '--all')
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
    TOPICS.hidden_flag(parser)


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


def _lazy(name: str) -> tuple[Run, AddArguments]:
    """Return a verb's two functions, of a module that is imported when they are called."""

    def arguments_of(parser: ArgumentParser) -> None:
        import_module(f'goalwire.apps.cli.commands.topic.{name}').add_arguments(parser)

    def run(arguments: Namespace, output: Output) -> Outcome | None:
        outcome: Outcome | None = import_module(f'goalwire.apps.cli.commands.topic.{name}').run(
            arguments, output
        )
        return outcome

    return run, arguments_of


NOUN = Noun(
    'topic',
    'Various topic related sub-commands',
    (
        Verb('bw', 'Display bandwidth used by topic', *_lazy('bw')),
        Verb('delay', 'Display delay of topic from timestamp in header', *_lazy('delay')),
        Verb('echo', 'Output messages from a topic', *_lazy('echo')),
        Verb(
            'find', 'Output a list of available topics of a given type', TOPICS.print_of_type, _find_arguments
        ),
        Verb('hz', 'Print the average receiving rate to screen', *_lazy('hz')),
        Verb('info', 'Print information about a topic', _info, _info_arguments),
        Verb('list', 'Output a list of available topics', _list, _list_arguments),
        Verb('plot', 'Draw fields of messages in the terminal', *_lazy('plot'), has_json=False),
        Verb('pub', 'Publish a message to a topic', *_lazy('pub')),
        Verb('type', "Print a topic's type", TOPICS.print_types, TOPICS.name_argument),
    ),
    TOPICS.noun_arguments,
)

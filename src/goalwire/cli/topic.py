"""ros2 topic: list, info, type, find, pub, echo, hz, bw, delay."""

from __future__ import annotations

from argparse import SUPPRESS, ArgumentParser, Namespace
from importlib import import_module
from typing import TYPE_CHECKING

from goalwire.cli import lookup
from goalwire.cli.discovery import add_graph_arguments, discovered
from goalwire.cli.outcome import Outcome
from goalwire.cli.verbs import AddArguments, Noun, Run, Verb

if TYPE_CHECKING:
    from goalwire.cli.output import Output
    from goalwire.graph.graph import Graph
    from goalwire.graph.names import NamesAndTypes

HIDDEN = 'Consider hidden topics as well'


def topics(graph: Graph, arguments: Namespace) -> NamesAndTypes:
    """Return the topics of the graph, hidden ones where they are asked for."""
    from goalwire.graph.names import without_hidden

    found = graph.topic_names_and_types()
    return found if arguments.include_hidden_topics else without_hidden(found)


def one_topic(arguments: Namespace, given: str | None = None) -> tuple[str, list[str], Graph]:
    """Return name, types and graph of the topic that is named; raises CommandError where it is not there."""
    from goalwire.graph.names import without_hidden

    name = lookup.full_name(given or arguments.topic_name, 'topic')

    def is_there(graph: Graph) -> bool:
        return lookup.types_of(graph.topic_names_and_types(), name) is not None

    with discovered(arguments, is_there) as graph:
        found = graph.topic_names_and_types()
    types = lookup.types_of(found, name)
    if types is None:
        raise lookup.unknown('topic', name, (each for each, _ in without_hidden(found)), 'ros2 topic list')
    return name, types, graph


def _noun_arguments(parser: ArgumentParser) -> None:
    parser.add_argument('--include-hidden-topics', action='store_true', default=False, help=HIDDEN)


def _hidden_argument(parser: ArgumentParser, *short: str) -> None:
    parser.add_argument('--include-hidden-topics', *short, action='store_true', default=SUPPRESS, help=HIDDEN)


def _name_argument(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument('topic_name', help="Name of the topic (e.g. '/chatter')")


def _list_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument('-t', '--show-types', action='store_true', help='Show the types, too')
    parser.add_argument(
        '-c', '--count-topics', '--count', action='store_true', help='Show only how many there are'
    )
    _hidden_argument(parser, '-a', '--all')
    parser.add_argument('-v', '--verbose', action='store_true', help='Show how many publish and subscribe')


def _list(arguments: Namespace, output: Output) -> None:
    from goalwire.transport.contract import EndpointKind

    with discovered(arguments) as graph:
        found = topics(graph, arguments)
    counts = {
        name: (graph.count(EndpointKind.PUBLISHER, name), graph.count(EndpointKind.SUBSCRIPTION, name))
        for name, _ in found
    }
    if arguments.count_topics:
        output.data(len(found)) if output.json else output.line(str(len(found)))
    elif output.json:
        for name, types in found:
            publishers, subscribers = counts[name]
            output.data({'name': name, 'types': types, 'publishers': publishers, 'subscribers': subscribers})
    elif arguments.verbose:
        for at, (title, noun) in enumerate((('Published', 'publisher'), ('Subscribed', 'subscriber'))):
            output.line(f'{title} topics:')
            for name, types in found:
                if n := counts[name][at]:
                    output.line(f' * {name} [{", ".join(types)}] {n} {noun}{"s" if n > 1 else ""}')
            output.line()
    else:
        for name, types in found:
            output.line(f'{name} [{", ".join(types)}]' if arguments.show_types else name)


def _type(arguments: Namespace, output: Output) -> None:
    name, types, _ = one_topic(arguments)
    if output.json:
        output.data({'name': name, 'types': types})
        return
    for each in types:
        output.line(each)


def _find_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument('topic_type', help="Type to look for (e.g. 'std_msgs/msg/String')")
    parser.add_argument(
        '-c', '--count-topics', '--count', action='store_true', help='Show only how many there are'
    )
    _hidden_argument(parser)


def _find(arguments: Namespace, output: Output) -> None:
    wanted = lookup.type_name(arguments.topic_type, 'msg')
    with discovered(arguments) as graph:
        found = [name for name, types in topics(graph, arguments) if wanted in types]
    if arguments.count_topics:
        output.data(len(found)) if output.json else output.line(str(len(found)))
        return
    for name in found:
        output.data({'name': name, 'types': [wanted]}) if output.json else output.line(name)


def _info_arguments(parser: ArgumentParser) -> None:
    _name_argument(parser)
    parser.add_argument('-v', '--verbose', action='store_true', help='Show nodes, type hashes and QoS, too')


def _info(arguments: Namespace, output: Output) -> None:
    from goalwire.cli.endpoints import as_json, as_text
    from goalwire.transport.contract import EndpointKind

    name, types, _ = one_topic(arguments)
    with discovered(arguments) as graph:  # all of it: one_topic may have looked at its beginning
        publishers = graph.entities(EndpointKind.PUBLISHER, name)
        subscribers = graph.entities(EndpointKind.SUBSCRIPTION, name)
    if output.json:
        output.data(
            {
                'name': name,
                'types': types,
                'publishers': [as_json(each) for each in publishers],
                'subscribers': [as_json(each) for each in subscribers],
            }
        )
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
        import_module(f'goalwire.cli.topic_{name}').add_arguments(parser)

    def run(arguments: Namespace, output: Output) -> Outcome | None:
        outcome: Outcome | None = import_module(f'goalwire.cli.topic_{name}').run(arguments, output)
        return outcome

    return run, arguments_of


NOUN = Noun(
    'topic',
    'Various topic related sub-commands',
    (
        Verb('bw', 'Display bandwidth used by topic', *_lazy('bw')),
        Verb('delay', 'Display delay of topic from timestamp in header', *_lazy('delay')),
        Verb('echo', 'Output messages from a topic', *_lazy('echo')),
        Verb('find', 'Output a list of available topics of a given type', _find, _find_arguments),
        Verb('hz', 'Print the average receiving rate to screen', *_lazy('hz')),
        Verb('info', 'Print information about a topic', _info, _info_arguments),
        Verb('list', 'Output a list of available topics', _list, _list_arguments),
        Verb('plot', 'Draw fields of messages in the terminal', *_lazy('plot'), has_json=False),
        Verb('pub', 'Publish a message to a topic', *_lazy('pub')),
        Verb('type', "Print a topic's type", _type, _name_argument),
    ),
    _noun_arguments,
)

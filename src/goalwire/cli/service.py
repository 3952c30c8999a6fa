"""ros2 service: list, type, info, find, call, echo."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.cli import lookup
from goalwire.cli.discovery import add_graph_arguments, discovered
from goalwire.cli.outcome import Outcome
from goalwire.cli.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.cli.output import Output
    from goalwire.graph.graph import Graph
    from goalwire.graph.names import NamesAndTypes

HIDDEN = 'Consider hidden services as well'


def services(graph: Graph, arguments: Namespace) -> NamesAndTypes:
    """Return the services of the graph, hidden ones where they are asked for."""
    from goalwire.graph.names import without_hidden

    found = graph.service_names_and_types()
    return found if arguments.include_hidden_services else without_hidden(found)


def _noun_arguments(parser: ArgumentParser) -> None:
    parser.add_argument('--include-hidden-services', action='store_true', default=False, help=HIDDEN)


def _hidden_argument(parser: ArgumentParser, *short: str) -> None:
    """Add the noun's flag to a verb as well, without undoing the noun's."""
    from argparse import SUPPRESS

    parser.add_argument(
        '--include-hidden-services', *short, action='store_true', default=SUPPRESS, help=HIDDEN
    )


def _name_argument(parser: ArgumentParser) -> None:
    parser.add_argument('service_name', help="Name of the service (e.g. '/add_two_ints')")


# -- list, type, find, info ----------------------------------------------------------------------------------


def _list_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument('-t', '--show-types', action='store_true', help='Show the types, too')
    parser.add_argument(
        '-c', '--count-services', '--count', action='store_true', help='Show only how many there are'
    )
    _hidden_argument(parser, '-a', '--all')


def _list(arguments: Namespace, output: Output) -> None:
    with discovered(arguments) as graph:
        found = services(graph, arguments)
    if arguments.count_services:
        output.data(len(found)) if output.json else output.line(str(len(found)))
    elif output.json:
        for name, types in found:
            output.data({'name': name, 'types': types})
    else:
        for name, types in found:
            output.line(f'{name} [{", ".join(types)}]' if arguments.show_types else name)


def _type_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    _name_argument(parser)


def _type(arguments: Namespace, output: Output) -> None:
    name, types, _ = _one(arguments)
    if output.json:
        output.data({'name': name, 'types': types})
    for each in () if output.json else types:
        output.line(each)


def _one(arguments: Namespace) -> tuple[str, list[str], Graph]:
    """Return the name, the types and the graph of the service that is named; raises CommandError."""
    name = lookup.full_name(arguments.service_name, 'service')

    def is_there(graph: Graph) -> bool:
        return lookup.types_of(graph.service_names_and_types(), name) is not None

    with discovered(arguments, is_there) as graph:
        found = graph.service_names_and_types()
    types = lookup.types_of(found, name)
    if types is None:
        raise lookup.unknown('service', name, _names(found), 'ros2 service list')
    return name, types, graph


def _names(found: NamesAndTypes) -> list[str]:
    from goalwire.graph.names import without_hidden

    return [name for name, _ in without_hidden(found)]


def _find_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument('service_type', help="Type to look for (e.g. 'std_srvs/srv/SetBool')")
    parser.add_argument(
        '-c', '--count-services', '--count', action='store_true', help='Show only how many there are'
    )
    _hidden_argument(parser)


def _find(arguments: Namespace, output: Output) -> None:
    wanted = lookup.type_name(arguments.service_type, 'srv')
    with discovered(arguments) as graph:
        found = [name for name, types in services(graph, arguments) if wanted in types]
    if arguments.count_services:
        output.data(len(found)) if output.json else output.line(str(len(found)))
        return
    for name in found:
        output.data({'name': name, 'types': [wanted]}) if output.json else output.line(name)


def _info_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    _name_argument(parser)
    parser.add_argument(
        '-v', '--verbose', action='store_true', help='Show the nodes of clients and servers, too'
    )


def _info(arguments: Namespace, output: Output) -> None:
    from goalwire.cli.endpoints import as_json, as_text
    from goalwire.transport.contract import EndpointKind

    name, types, graph = _one(arguments)
    clients = graph.entities(EndpointKind.CLIENT, name)
    servers = graph.entities(EndpointKind.SERVICE, name)
    if output.json:
        output.data(
            {
                'name': name,
                'types': types,
                'clients': [as_json(each) for each in clients],
                'servers': [as_json(each) for each in servers],
            }
        )
        return
    output.line(f'Type: {types[0] if len(types) == 1 else types}')
    for title, endpoints in (('Clients', clients), ('Services', servers)):
        output.line(f'{title} count: {len(endpoints)}')
        if arguments.verbose:
            output.line()
            for each in endpoints:
                output.block(as_text(each), end='\n\n')


# -- call, echo ----------------------------------------------------------------------------------------------


def _call_arguments(parser: ArgumentParser) -> None:
    from goalwire.cli.service_call import call_arguments

    add_graph_arguments(parser)
    _name_argument(parser)
    call_arguments(parser)


def _call(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.cli.service_call import call

    return call(arguments, output)


def _echo_arguments(parser: ArgumentParser) -> None:
    from goalwire.cli.messages import add_style_arguments

    add_graph_arguments(parser)
    _name_argument(parser)
    parser.add_argument('service_type', nargs='?', help='Type of the service, if the graph does not know it')
    add_style_arguments(parser)


def _echo(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.cli.service_echo import echo

    return echo(arguments, output)


NOUN = Noun(
    'service',
    'Various service related sub-commands',
    (
        Verb('call', 'Call a service', _call, _call_arguments),
        Verb('echo', 'Echo the steps of the calls of a service', _echo, _echo_arguments),
        Verb('find', 'Output a list of available services of a given type', _find, _find_arguments),
        Verb('info', 'Print information about a service', _info, _info_arguments),
        Verb('list', 'Output a list of available services', _list, _list_arguments),
        Verb('type', "Output a service's type", _type, _type_arguments),
    ),
    _noun_arguments,
)

"""ros2 service: list, type, info, find, call, echo."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.entity_kinds import SERVICES
from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def _list_arguments(parser: ArgumentParser) -> None:
    SERVICES.list_arguments(parser)
    SERVICES.add_hidden_flag(parser, '-a', '--all')


def _find_arguments(parser: ArgumentParser) -> None:
    SERVICES.find_arguments(parser)
    SERVICES.add_hidden_flag(parser)


def _info_arguments(parser: ArgumentParser) -> None:
    SERVICES.name_argument(parser)
    parser.add_argument(
        '-v', '--verbose', action='store_true', help='Show the nodes of clients and servers, too'
    )


def _info(arguments: Namespace, output: Output) -> None:
    from goalwire.apps.cli.framework.endpoints import as_json, as_text
    from goalwire.transport.contract import EndpointKind

    name, types, graph = SERVICES.one(arguments, whole=True)
    clients = graph.entities(EndpointKind.CLIENT, name)
    servers = graph.entities(EndpointKind.SERVICE, name)
    if output.json:
        groups = {'clients': list(map(as_json, clients)), 'servers': list(map(as_json, servers))}
        output.data({'name': name, 'types': types, **groups})
        return
    output.line(f'Type: {types[0] if len(types) == 1 else types}')
    for title, endpoints in (('Clients', clients), ('Services', servers)):
        output.line(f'{title} count: {len(endpoints)}')
        if arguments.verbose:
            output.line()
            for each in endpoints:
                output.block(as_text(each), end='\n\n')


NOUN = Noun(
    'service',
    'Various service related sub-commands',
    (
        Verb('call', 'Call a service', *lazy('service.call')),
        Verb('echo', 'Echo the steps of the calls of a service', *lazy('service.echo')),
        Verb(
            'find',
            'Output a list of available services of a given type',
            SERVICES.print_of_type,
            _find_arguments,
        ),
        Verb('info', 'Print information about a service', _info, _info_arguments),
        Verb('list', 'Output a list of available services', SERVICES.print_all, _list_arguments),
        Verb('type', "Output a service's type", SERVICES.print_types, SERVICES.name_argument),
    ),
    SERVICES.noun_arguments,
)

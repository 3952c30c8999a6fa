"""ros2 service: list, type, info, find, call, echo."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.named import SERVICES
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def _list_arguments(parser: ArgumentParser) -> None:
    SERVICES.list_arguments(parser)
    SERVICES.hidden_flag(parser, '-a', '--all')


def _find_arguments(parser: ArgumentParser) -> None:
    SERVICES.find_arguments(parser)
    SERVICES.hidden_flag(parser)


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


# -- call, echo ----------------------------------------------------------------------------------------------


def _call_arguments(parser: ArgumentParser) -> None:
    from goalwire.apps.cli.commands.service.call import call_arguments

    SERVICES.name_argument(parser)
    call_arguments(parser)


def _call(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.apps.cli.commands.service.call import call

    return call(arguments, output)


def _echo_arguments(parser: ArgumentParser) -> None:
    from goalwire.apps.cli.framework.messages import add_style_arguments
    from goalwire.apps.cli.framework.qos import add_qos_arguments

    SERVICES.name_argument(parser)
    parser.add_argument('service_type', nargs='?', help='Type of the service, if the graph does not know it')
    add_style_arguments(parser)
    add_qos_arguments(parser, 'subscribe', 'reliable, with a long queue')


def _echo(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.apps.cli.commands.service.echo import echo

    return echo(arguments, output)


NOUN = Noun(
    'service',
    'Various service related sub-commands',
    (
        Verb('call', 'Call a service', _call, _call_arguments),
        Verb('echo', 'Echo the steps of the calls of a service', _echo, _echo_arguments),
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

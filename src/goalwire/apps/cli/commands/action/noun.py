"""ros2 action: list, type, info, find, send_goal, echo; and attach, cancel, goals, probe, watch."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.entity_kinds import ACTIONS
from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def _info_arguments(parser: ArgumentParser) -> None:
    ACTIONS.name_argument(parser)
    parser.add_argument('-t', '--show-types', action='store_true', help='Show the types, too')
    parser.add_argument('-c', '--count', action='store_true', help='Show only how many there are')


def _info(arguments: Namespace, output: Output) -> None:
    from goalwire.graph.names import SEND_GOAL, show_type
    from goalwire.transport.contract import EndpointKind

    name, types, graph = ACTIONS.one(arguments, whole=True)
    clients = graph.entities(EndpointKind.CLIENT, name + SEND_GOAL)
    servers = graph.entities(EndpointKind.SERVICE, name + SEND_GOAL)
    if output.json:
        nodes = {
            title: [{'node': each.node.qualified, 'type': show_type(each.type_name)} for each in found]
            for title, found in (('clients', clients), ('servers', servers))
        }
        output.data({'name': name, 'types': types, **nodes})
        return
    output.line(f'Action: {name}')
    for title, found in (('clients', clients), ('servers', servers)):
        output.line(f'Action {title}: {len(found)}')
        for each in () if arguments.count else found:
            kind = f' [{show_type(each.type_name)}]' if arguments.show_types else ''
            output.line(f'    {each.node.qualified}{kind}')


NOUN = Noun(
    'action',
    'Various action related sub-commands',
    (
        Verb('attach', 'Follow a goal that was sent before', *lazy('action.known_goals', 'attach')),
        Verb('cancel', 'Cancel goals of an action', *lazy('action.cancel')),
        Verb('echo', 'Echo what happens to the goals of an action', *lazy('action.echo')),
        Verb(
            'find',
            'Output a list of available actions of a given type',
            ACTIONS.print_of_type,
            ACTIONS.find_arguments,
        ),
        Verb('goals', 'Output a list of the goals of an action', *lazy('action.known_goals', 'list_goals')),
        Verb('info', 'Print information about an action', _info, _info_arguments),
        Verb('list', 'Output a list of action names', ACTIONS.print_all, ACTIONS.list_arguments),
        Verb('probe', 'Print the state of a goal that was sent before', *lazy('action.known_goals', 'probe')),
        Verb('send_goal', 'Send an action goal', *lazy('action.send_goal')),
        Verb('type', "Print an action's type", ACTIONS.print_types, ACTIONS.name_argument),
        Verb('watch', 'Show the goals of an action while they run', *lazy('action.watch')),
    ),
)

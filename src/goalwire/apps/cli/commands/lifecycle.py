"""ros2 lifecycle: nodes, list, get, set."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.framework.discovery import add_graph_arguments, discovered
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.nodes import add_node_argument, call, find_node, node_names
from goalwire.apps.cli.framework.numbers import positive
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

_GET_STATE = 'lifecycle_msgs/srv/GetState'


def _lifecycle_nodes(arguments: Namespace, *, include_hidden: bool) -> list[str]:
    """Return the nodes that have a lifecycle."""
    with discovered(arguments) as graph:
        serving = {name for name, types in graph.service_names_and_types() if _GET_STATE in types}
        names = node_names(graph, include_hidden=include_hidden)
    return [name for name in names if f'{name}/get_state' in serving]


def _find_node(arguments: Namespace) -> str:
    """Return the named node; raises CommandError if it has no lifecycle."""
    name = find_node(arguments)
    if name not in _lifecycle_nodes(arguments, include_hidden=True):
        raise CommandError(
            Outcome.NOT_FOUND, f"the node '{name}' has no lifecycle", 'see: ros2 lifecycle nodes'
        )
    return name


def _service_timeout(parser: ArgumentParser) -> None:
    parser.add_argument(
        '--service-timeout', '--timeout', metavar='N', type=positive, help='Seconds for an answer (5)'
    )


def _nodes_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument('-a', '--all', action='store_true', help='Show hidden nodes, too')
    parser.add_argument(
        '-c', '--count-nodes', '--count', action='store_true', help='Show only how many there are'
    )


def _nodes(arguments: Namespace, output: Output) -> None:
    names = _lifecycle_nodes(arguments, include_hidden=arguments.all)
    if arguments.count_nodes:
        output.show(len(names), str(len(names)))
        return
    for name in names:
        output.show({'name': name}, name)


def _node_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    add_node_argument(parser)
    _service_timeout(parser)


def _list_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument('node_name', help="Name of the node (e.g. '/talker')")
    parser.add_argument('--include-hidden-nodes', action='store_true', help='Consider hidden nodes as well')
    _service_timeout(parser)
    parser.add_argument(
        '-a', '--all', action='store_true', help='Show all transitions, not only the possible ones'
    )


async def _transitions(node: goalwire.Node, name: str, service: str, arguments: Namespace) -> list[Any]:
    from lifecycle_msgs.srv import GetAvailableTransitions

    response = await call(node, GetAvailableTransitions, f'{name}/{service}', arguments, {})
    found: list[Any] = list(response.available_transitions)
    return found


def _list(arguments: Namespace, output: Output) -> Outcome:
    name = _find_node(arguments)
    service = 'get_transition_graph' if arguments.all else 'get_available_transitions'

    async def show(node: goalwire.Node) -> None:
        for each in await _transitions(node, name, service, arguments):
            transition, start, goal = each.transition, each.start_state, each.goal_state
            if output.json:
                output.data(
                    {'id': transition.id, 'label': transition.label, 'start': start.label, 'goal': goal.label}
                )
                continue
            output.line(f'- {transition.label} [{transition.id}]')
            output.block(f'\tStart: {start.label}')
            output.block(f'\tGoal: {goal.label}')

    return live(show)


def _get_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    add_node_argument(parser, optional=True)
    _service_timeout(parser)


def _get(arguments: Namespace, output: Output) -> Outcome:
    if arguments.node_name:
        names = [_find_node(arguments)]
    else:
        names = _lifecycle_nodes(arguments, include_hidden=arguments.include_hidden_nodes)

    async def show(node: goalwire.Node) -> Outcome:
        from lifecycle_msgs.srv import GetState

        outcome = Outcome.OK
        for name in names:
            try:
                state = (await call(node, GetState, f'{name}/get_state', arguments, {})).current_state
            except goalwire.CallError as error:
                if arguments.node_name:
                    raise
                tell(f"Exception while calling service of node '{name}': {error}")
                outcome = Outcome.SERVER_LOST
                continue
            output.show(
                {'node': name, 'id': state.id, 'label': state.label},
                f'{"" if arguments.node_name else f"{name}: "}{state.label} [{state.id}]',
            )
        return outcome

    return live(show)


def _set_arguments(parser: ArgumentParser) -> None:
    _node_arguments(parser)
    parser.add_argument('transition', help='Label or number of the transition (e.g. configure)')


def _set(arguments: Namespace, output: Output) -> Outcome:
    name = _find_node(arguments)

    async def change(node: goalwire.Node) -> Outcome:
        from lifecycle_msgs.srv import ChangeState

        found = await _transitions(node, name, 'get_available_transitions', arguments)
        transitions = [each.transition for each in found]
        wanted = [each for each in transitions if arguments.transition in {each.label, str(each.id)}]
        if not wanted:
            possible = ', '.join(f'{each.label} [{each.id}]' for each in transitions)
            raise CommandError(
                Outcome.BAD_VALUE,
                f"'{name}' cannot do '{arguments.transition}' now",
                f'available are: {possible or "none"}',
            )
        client_fields = {'transition': wanted[0]}
        response = await call(node, ChangeState, f'{name}/change_state', arguments, client_fields)
        if output.json:
            output.data({'node': name, 'transition': wanted[0].label, 'success': response.success})
        if not response.success:
            raise CommandError(Outcome.REFUSED, 'Transitioning failed', f'see: ros2 lifecycle get {name}')
        if not output.json:
            output.line('Transitioning successful')
        return Outcome.OK

    return live(change)


NOUN = Noun(
    'lifecycle',
    'Various lifecycle related sub-commands',
    (
        Verb('get', 'Get lifecycle state for one or more nodes', _get, _get_arguments),
        Verb('list', 'Output a list of available transitions', _list, _list_arguments),
        Verb('nodes', 'Output a list of nodes with lifecycle', _nodes, _nodes_arguments),
        Verb('set', 'Trigger lifecycle state transition', _set, _set_arguments),
    ),
)

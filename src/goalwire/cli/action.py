"""ros2 action: list, type, info, find, send_goal, echo; and goals, cancel, watch."""

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


def name_argument(parser: ArgumentParser) -> None:
    """Add the name of the action, and the flags of all that look at the graph."""
    add_graph_arguments(parser)
    parser.add_argument('action_name', help="Name of the action (e.g. '/fibonacci')")


def type_in_graph(arguments: Namespace) -> tuple[str, str]:
    """Return name and type of the action that is named; raises CommandError where it is not in the graph."""
    name, types, _ = _one(arguments)
    return name, lookup.only_type(types, 'action', name, arguments.prog)


def _one(arguments: Namespace) -> tuple[str, list[str], Graph]:
    name = lookup.full_name(arguments.action_name, 'action')

    def is_there(graph: Graph) -> bool:
        return lookup.types_of(graph.action_names_and_types(), name) is not None

    with discovered(arguments, is_there) as graph:
        found = graph.action_names_and_types()
    types = lookup.types_of(found, name)
    if types is None:
        raise lookup.unknown('action', name, (each for each, _ in found), 'ros2 action list')
    return name, types, graph


def _list_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument('-t', '--show-types', action='store_true', help='Show the types, too')
    parser.add_argument(
        '-c', '--count-actions', '--count', action='store_true', help='Show only how many there are'
    )


def _list(arguments: Namespace, output: Output) -> None:
    with discovered(arguments) as graph:
        found = graph.action_names_and_types()
    if arguments.count_actions:
        output.data(len(found)) if output.json else output.line(str(len(found)))
        return
    for name, types in found:
        if output.json:
            output.data({'name': name, 'types': types})
        else:
            output.line(f'{name} [{", ".join(types)}]' if arguments.show_types else name)


def _type_arguments(parser: ArgumentParser) -> None:
    name_argument(parser)


def _type(arguments: Namespace, output: Output) -> None:
    name, types, _ = _one(arguments)
    if output.json:
        output.data({'name': name, 'types': types})
        return
    for each in types:
        output.line(each)


def _find_arguments(parser: ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument('action_type', help="Type to look for (e.g. 'example_interfaces/action/Fibonacci')")
    parser.add_argument(
        '-c', '--count-actions', '--count', action='store_true', help='Show only how many there are'
    )


def _find(arguments: Namespace, output: Output) -> None:
    wanted = lookup.type_name(arguments.action_type, 'action')
    with discovered(arguments) as graph:
        found = [name for name, types in graph.action_names_and_types() if wanted in types]
    if arguments.count_actions:
        output.data(len(found)) if output.json else output.line(str(len(found)))
        return
    for name in found:
        output.data({'name': name, 'types': [wanted]}) if output.json else output.line(name)


def _info_arguments(parser: ArgumentParser) -> None:
    name_argument(parser)
    parser.add_argument('-t', '--show-types', action='store_true', help='Show the types, too')
    parser.add_argument('-c', '--count', action='store_true', help='Show only how many there are')


def _info(arguments: Namespace, output: Output) -> None:
    from goalwire.graph.names import SEND_GOAL, shown
    from goalwire.transport.contract import EndpointKind

    name, types, _graph = _one(arguments)
    with discovered(arguments) as graph:  # all of it: `_one` may have looked at its beginning
        clients = graph.entities(EndpointKind.CLIENT, name + SEND_GOAL)
        servers = graph.entities(EndpointKind.SERVICE, name + SEND_GOAL)
    if output.json:
        nodes = {
            title: [{'node': each.node.qualified, 'type': shown(each.type_name)} for each in found]
            for title, found in (('clients', clients), ('servers', servers))
        }
        output.data({'name': name, 'types': types, **nodes})
        return
    output.line(f'Action: {name}')
    for title, found in (('clients', clients), ('servers', servers)):
        output.line(f'Action {title}: {len(found)}')
        for each in () if arguments.count else found:
            kind = f' [{shown(each.type_name)}]' if arguments.show_types else ''
            output.line(f'    {each.node.qualified}{kind}')


# -- what takes part in the graph; imported when it is called for -------------------------------------------


def _send_goal_arguments(parser: ArgumentParser) -> None:
    from goalwire.cli.send_goal import send_goal_arguments

    name_argument(parser)
    send_goal_arguments(parser)


def _send_goal(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.cli.send_goal import send_goal

    return send_goal(arguments, output)


def _echo_arguments(parser: ArgumentParser) -> None:
    from goalwire.cli.action_echo import echo_arguments

    name_argument(parser)
    echo_arguments(parser)


def _echo(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.cli.action_echo import echo

    return echo(arguments, output)


def _goals_arguments(parser: ArgumentParser) -> None:
    from goalwire.cli.goals import goals_arguments

    name_argument(parser)
    goals_arguments(parser)


def _goals(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.cli.goals import goals

    return goals(arguments, output)


def _cancel_arguments(parser: ArgumentParser) -> None:
    from goalwire.cli.goals import cancel_arguments

    name_argument(parser)
    cancel_arguments(parser)


def _cancel(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.cli.goals import cancel

    return cancel(arguments, output)


def _watch_arguments(parser: ArgumentParser) -> None:
    from goalwire.cli.watch_goals import watch_arguments

    name_argument(parser)
    watch_arguments(parser)


def _watch(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.cli.watch_goals import watch

    return watch(arguments, output)


NOUN = Noun(
    'action',
    'Various action related sub-commands',
    (
        Verb('cancel', 'Cancel goals of an action', _cancel, _cancel_arguments),
        Verb('echo', 'Echo what happens to the goals of an action', _echo, _echo_arguments),
        Verb('find', 'Output a list of available actions of a given type', _find, _find_arguments),
        Verb('goals', 'Output a list of the goals of an action', _goals, _goals_arguments),
        Verb('info', 'Print information about an action', _info, _info_arguments),
        Verb('list', 'Output a list of action names', _list, _list_arguments),
        Verb('send_goal', 'Send an action goal', _send_goal, _send_goal_arguments),
        Verb('type', "Print an action's type", _type, _type_arguments),
        Verb('watch', 'Show the goals of an action as they go on', _watch, _watch_arguments),
    ),
)

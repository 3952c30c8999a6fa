"""goalwire secure learn: watches a system at work, and writes the policy that it needs."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.discovery import add_graph_arguments, discovered
from goalwire.apps.cli.framework.numbers import seconds
from goalwire.apps.cli.framework.outcome import CommandError, Outcome

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.graph.graph import Graph


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure learn`."""
    parser.add_argument(
        '--for',
        dest='wait',
        metavar='SECONDS',
        type=seconds,
        default=10.0,
        help='How long to watch (default: 10)',
    )
    parser.add_argument('-o', '--output', metavar='FILE', type=Path, help='A new file to write the policy to')
    add_graph_arguments(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Watch the graph, and write a policy that allows what was seen."""
    from goalwire.security.learning import Need, write_policy
    from goalwire.security.storage import PUBLIC, create
    from goalwire.transport.zenoh.policy_questions import need_of

    needs: dict[Need, None] = {}

    def look(graph: Graph) -> bool:
        for entity in graph.endpoints():
            identity = (entity.node.enclave or '/').strip('/').replace('/', '.') or 'robot'
            wanted = need_of(entity)
            needs[Need(identity, entity.node.qualified, wanted.verbs[0], wanted.name)] = None
        return False

    with discovered(arguments, look, wait=arguments.wait, whole=True) as graph:
        look(graph)
    if not needs:
        raise CommandError(Outcome.NOT_FOUND, 'no node was seen', 'see: ros2 node list')
    text = write_policy(needs)
    if arguments.output is None:
        output.block(text, end='')
        return
    try:
        create(arguments.output, text.encode(), PUBLIC)
    except FileExistsError:
        problem = f"'{arguments.output}' is there already"
        raise CommandError(Outcome.FAILED, problem, 'name another file') from None

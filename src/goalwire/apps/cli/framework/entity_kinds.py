"""The kinds of entities that commands name (services, topics, actions), and the verbs that all kinds have."""

from __future__ import annotations

from argparse import SUPPRESS, ArgumentParser, Namespace
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.discovery import add_graph_arguments, discovered

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.graph.graph import Graph
    from goalwire.graph.names import NamesAndTypes


class EntityKind:
    """A kind of entity in the graph, 'service', 'topic' or 'action', and the verbs that all kinds share."""

    def __init__(
        self, what: str, kind: str, example: str, all_names: Callable[[Graph], NamesAndTypes]
    ) -> None:
        """`kind` is the middle of a type's name: srv, msg or action. `example` is a type and a name."""
        self.what = what
        self._kind = kind
        self._example_type, self._example_name = example.split()
        self._all_names = all_names

    # -- arguments -----------------------------------------------------------------------------------------

    def add_hidden_flag(self, parser: ArgumentParser, *short: str, default: object = SUPPRESS) -> None:
        """Add the flag for hidden names, to noun and verb; its absence at the verb keeps the noun's flag."""
        parser.add_argument(
            f'--include-hidden-{self.what}s',
            *short,
            dest='include_hidden',
            action='store_true',
            default=default,
            help=f'Consider hidden {self.what}s as well',
        )

    def noun_arguments(self, parser: ArgumentParser) -> None:
        """Add the arguments between noun and verb."""
        self.add_hidden_flag(parser, default=False)

    def name_argument(self, parser: ArgumentParser) -> None:
        """Add the argument for the name, and the flags of every command that looks at the graph."""
        add_graph_arguments(parser)
        article = 'an' if self.what[0] in 'aeiou' else 'a'
        parser.add_argument(
            f'{self.what}_name', help=f"Name of {article} {self.what} (e.g. '{self._example_name}')"
        )

    def list_arguments(self, parser: ArgumentParser) -> None:
        """Add the arguments of `list`, except for hidden names."""
        add_graph_arguments(parser)
        parser.add_argument('-t', '--show-types', action='store_true', help='Show the types, too')
        self._count_flag(parser)

    def find_arguments(self, parser: ArgumentParser) -> None:
        """Add the arguments of `find`, except for hidden names."""
        add_graph_arguments(parser)
        parser.add_argument(f'{self.what}_type', help=f"Type to look for (e.g. '{self._example_type}')")
        self._count_flag(parser)

    def _count_flag(self, parser: ArgumentParser) -> None:
        parser.add_argument(
            '-c',
            f'--count-{self.what}s',
            '--count',
            dest='count',
            action='store_true',
            help='Show only how many there are',
        )

    # -- looking -------------------------------------------------------------------------------------------

    def names(self, graph: Graph, arguments: Namespace) -> NamesAndTypes:
        """Return names and types in the graph, hidden ones on request."""
        from goalwire.graph.names import without_hidden

        found = self._all_names(graph)
        return found if getattr(arguments, 'include_hidden', False) else without_hidden(found)

    def one(
        self, arguments: Namespace, given: str | None = None, *, whole: bool = False
    ) -> tuple[str, list[str], Graph]:
        """Return the full name of `given` or of the command line's name, its types, and the graph.

        The graph is complete only with `whole`. Raises CommandError if the name is not in the graph.
        """
        from goalwire.graph.names import without_hidden

        name = lookup.full_name(given or getattr(arguments, f'{self.what}_name'), self.what)

        def is_there(graph: Graph) -> bool:
            return lookup.types_of(self._all_names(graph), name) is not None

        with discovered(arguments, is_there, whole=whole) as graph:
            found = self._all_names(graph)
        types = lookup.types_of(found, name)
        if types is None:
            known = [each for each, _ in without_hidden(found)]
            raise lookup.unknown(self.what, name, known, f'ros2 {self.what} list')
        return name, types, graph

    def name_and_type(self, arguments: Namespace) -> tuple[str, str]:
        """Return the name and type of the named thing; raises CommandError if it is not in the graph."""
        name, types, _ = self.one(arguments)
        return name, lookup.only_type(types, self.what, name, arguments.prog)

    # -- verbs ---------------------------------------------------------------------------------------------

    def print_all(self, arguments: Namespace, output: Output) -> None:
        """Print all names."""
        with discovered(arguments) as graph:
            found = self.names(graph, arguments)
        if arguments.count:
            self._print_number(found, output)
            return
        for name, types in found:
            output.show(
                {'name': name, 'types': types},
                f'{name} [{", ".join(types)}]' if arguments.show_types else name,
            )

    def print_types(self, arguments: Namespace, output: Output) -> None:
        """Print the types of the named thing."""
        name, types, _ = self.one(arguments)
        if output.json:
            output.data({'name': name, 'types': types})
            return
        for each in types:
            output.line(each)

    def print_of_type(self, arguments: Namespace, output: Output) -> None:
        """Print the names that have a type."""
        wanted = lookup.type_name(getattr(arguments, f'{self.what}_type'), self._kind)
        with discovered(arguments) as graph:
            found = [name for name, types in self.names(graph, arguments) if wanted in types]
        if arguments.count:
            self._print_number(found, output)
            return
        for name in found:
            output.show({'name': name, 'types': [wanted]}, name)

    def _print_number(self, found: Iterable[object], output: Output) -> None:
        number = sum(1 for _ in found)
        output.show(number, str(number))


SERVICES = EntityKind(
    'service', 'srv', 'std_srvs/srv/SetBool /add_two_ints', lambda graph: graph.service_names_and_types()
)
TOPICS = EntityKind(
    'topic', 'msg', 'std_msgs/msg/String /chatter', lambda graph: graph.topic_names_and_types()
)
ACTIONS = EntityKind(
    'action',
    'action',
    'example_interfaces/action/Fibonacci /fibonacci',
    lambda graph: graph.action_names_and_types(),
)

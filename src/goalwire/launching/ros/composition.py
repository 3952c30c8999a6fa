"""Composable nodes: shared libraries of C++, which goalwire has no container for.

The classes are there so that a launch file can be read, shown and checked; carrying one out says what to do.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NoReturn

from goalwire.errors import LaunchError
from goalwire.launching.exposure import expose_action
from goalwire.launching.frontend import Entity, Parser
from goalwire.launching.model import Action, LaunchContext, SomeSubstitutions
from goalwire.launching.values import describe_text, normalize_to_list_of_substitutions

_ADVICE = (
    'composable nodes are C++ libraries that a container of ROS 2 loads: launch this part with a sourced '
    "ROS 2, or run the package's ordinary executable with Node(package=…, executable=…)"
)


class ComposableNode:
    """A node that a container is to load."""

    def __init__(
        self,
        *,
        package: SomeSubstitutions,
        plugin: SomeSubstitutions,
        name: SomeSubstitutions | None = None,
        namespace: SomeSubstitutions | None = None,
        parameters: Sequence[Any] | None = None,
        remappings: Iterable[Any] | None = None,
        extra_arguments: Sequence[Any] | None = None,
        condition: Any = None,
    ) -> None:
        self.package = normalize_to_list_of_substitutions(package)
        self.node_plugin = normalize_to_list_of_substitutions(plugin)
        self.node_name = None if name is None else normalize_to_list_of_substitutions(name)
        self.node_namespace = None if namespace is None else normalize_to_list_of_substitutions(namespace)
        self.parameters = parameters
        self.remappings = remappings
        self.extra_arguments = extra_arguments
        self.condition = condition


class _Refused(Action):
    def __init__(self, what: str, **options: Any) -> None:
        condition = options.pop('condition', None)
        super().__init__(condition=condition)
        self._what = what

    def describe(self) -> str:
        return f'{type(self).__name__}({self._what})'

    def execute(self, context: LaunchContext) -> NoReturn:
        raise LaunchError(f'{self.describe()}: {_ADVICE}')

    @classmethod
    def _read_all(cls, entity: Entity, parser: Parser) -> dict[str, Any]:
        _, arguments = Action.parse(entity, parser)
        _consume(entity)
        return arguments


def _consume(entity: Entity) -> None:
    """Read a tag whole: what is in it is judged by who carries it out."""
    for name in list(entity.attribute_names()):
        entity.get_attr(name, data_type=None, optional=True)
    for child in entity.children:
        _consume(child)


@expose_action('node_container')
class ComposableNodeContainer(_Refused):
    """A process that loads composable nodes."""

    def __init__(
        self,
        *,
        name: SomeSubstitutions = '',
        namespace: SomeSubstitutions = '',
        composable_node_descriptions: Iterable[ComposableNode] | None = None,
        **options: Any,
    ) -> None:
        super().__init__(describe_text(name), **options)
        self.composable_node_descriptions = list(composable_node_descriptions or ())

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        name = entity.get_attr('name', optional=True) or ''
        return cls, cls._read_all(entity, parser) | {'name': parser.parse_substitution(name)}


@expose_action('load_composable_node')
class LoadComposableNodes(_Refused):
    """Loads composable nodes into a container that runs."""

    def __init__(
        self,
        *,
        composable_node_descriptions: Iterable[ComposableNode] = (),
        target_container: Any = '',
        **options: Any,
    ) -> None:
        text = describe_text(target_container) if isinstance(target_container, str | list) else 'a container'
        super().__init__(text, **options)
        self.composable_node_descriptions = list(composable_node_descriptions)

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        target = entity.get_attr('target', optional=True) or ''
        return cls, cls._read_all(entity, parser) | {'target_container': parser.parse_substitution(target)}

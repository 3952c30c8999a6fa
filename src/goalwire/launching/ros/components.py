"""Composable nodes as launch files describe them: node classes that a container process loads."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from goalwire.launching.frontend import Entity, Parser
from goalwire.launching.model import Condition, SomeSubstitutions, Substitution
from goalwire.launching.ros.parameters import SomeParameters, normalize_parameters, parse_parameters
from goalwire.launching.ros.remappings import (
    RemapRule,
    SomeRemapRules,
    normalize_remap_rules,
    parse_remappings,
)
from goalwire.launching.values import describe_text, normalize_to_list_of_substitutions


class ComposableNode:
    """Describes a node that a container loads: a package's plugin, with names, parameters and remappings."""

    def __init__(
        self,
        *,
        package: SomeSubstitutions,
        plugin: SomeSubstitutions,
        name: SomeSubstitutions | None = None,
        namespace: SomeSubstitutions | None = None,
        parameters: SomeParameters | None = None,
        remappings: SomeRemapRules | None = None,
        extra_arguments: SomeParameters | None = None,
        condition: Condition | None = None,
    ) -> None:
        self._package = normalize_to_list_of_substitutions(package)
        self._plugin = normalize_to_list_of_substitutions(plugin)
        self._name = None if name is None else normalize_to_list_of_substitutions(name)
        self._namespace = None if namespace is None else normalize_to_list_of_substitutions(namespace)
        self._parameters = None if parameters is None else normalize_parameters(parameters)
        self._remappings = None if not remappings else list(normalize_remap_rules(remappings))
        self._extra_arguments = None if not extra_arguments else normalize_parameters(extra_arguments)
        self._condition = condition

    @classmethod
    def parse(cls, parser: Parser, entity: Entity) -> tuple[type[ComposableNode], dict[str, Any]]:
        """Read a <composable_node>: the class and its keyword arguments."""
        arguments: dict[str, Any] = {'package': parser.parse_substitution(entity.get_attr('pkg'))}
        for attribute, needed in {'plugin': True, 'name': True, 'namespace': False}.items():
            value = entity.get_attr(attribute, optional=not needed)
            if value is not None:
                arguments[attribute] = parser.parse_substitution(value)
        condition = parser.parse_condition(entity)
        if condition is not None:
            arguments['condition'] = condition
        arguments['parameters'] = parse_parameters(entity.get_entities('param'), parser)
        arguments['remappings'] = parse_remappings(entity.get_entities('remap'), parser)
        arguments['extra_arguments'] = [
            _extra_argument(item, parser) for item in entity.get_entities('extra_arg')
        ]
        entity.assert_entity_completely_parsed()
        return cls, arguments

    @property
    def package(self) -> list[Substitution]:
        return self._package

    @property
    def node_plugin(self) -> list[Substitution]:
        return self._plugin

    @property
    def node_name(self) -> list[Substitution] | None:
        return self._name

    @property
    def node_namespace(self) -> list[Substitution] | None:
        return self._namespace

    @property
    def parameters(self) -> tuple[Any, ...] | None:
        return self._parameters

    @property
    def remappings(self) -> list[RemapRule] | None:
        return self._remappings

    @property
    def extra_arguments(self) -> tuple[Any, ...] | None:
        return self._extra_arguments

    def condition(self) -> Condition | None:
        """Return the condition under which the component is loaded; None if it is always loaded."""
        return self._condition

    def describe(self) -> str:
        """Return the component's package and plugin as a short text."""
        return f'{describe_text(self._package)} {describe_text(self._plugin)}'


def parse_components(entities: Iterable[Entity], parser: Parser) -> list[ComposableNode]:
    """Read the <composable_node> tags of a container."""
    return [
        made(**arguments) for made, arguments in (ComposableNode.parse(parser, item) for item in entities)
    ]


def _extra_argument(entity: Entity, parser: Parser) -> dict[Any, Any]:
    name = tuple(parser.parse_substitution(entity.get_attr('name')))
    value = parser.parse_substitution(entity.get_attr('value'))
    entity.assert_entity_completely_parsed()
    return {name: value}

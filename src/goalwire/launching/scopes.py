"""Actions that set launch configurations and environment variables for the actions after them, and groups."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from typing import Any, ClassVar

from goalwire.launching.exposure import expose_action
from goalwire.launching.frontend import Entity, Parser, parse_texts
from goalwire.launching.model import (
    Action,
    LaunchContext,
    LaunchDescriptionEntity,
    SomeSubstitutions,
    Substitution,
    entity_list,
)
from goalwire.launching.values import (
    describe_text,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    perform_text,
)


class _Naming(Action):
    """The base of actions on a launch configuration or environment variable that is given by its name."""

    TAGGED: ClassVar[tuple[str, ...]] = ('name',)
    """The attributes of the action's tag; the constructor's arguments have the same names."""

    def __init__(self, name: SomeSubstitutions, **options: Any) -> None:
        super().__init__(**options)
        self.name = normalize_to_list_of_substitutions(name)

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        return cls, arguments | parse_texts(entity, parser, *cls.TAGGED)

    def describe(self) -> str:
        return f'{type(self).__name__}({describe_text(self.name)})'


class _Setting(_Naming):
    """The base of actions that set a launch configuration or environment variable to a value."""

    TAGGED = ('name', 'value')

    def __init__(self, name: SomeSubstitutions, value: SomeSubstitutions, **options: Any) -> None:
        super().__init__(name, **options)
        self.value = normalize_to_list_of_substitutions(value)

    def describe(self) -> str:
        return f'{type(self).__name__}({describe_text(self.name)}, {describe_text(self.value)})'


# -- launch configurations -----------------------------------------------------------------------------------


@expose_action('let')
class SetLaunchConfiguration(_Setting):
    """Sets a launch configuration."""

    def execute(self, context: LaunchContext) -> None:
        name = perform_substitutions(context, self.name)
        context.launch_configurations[name] = perform_substitutions(context, self.value)


@expose_action('unset')
class UnsetLaunchConfiguration(_Naming):
    """Removes a launch configuration."""

    def execute(self, context: LaunchContext) -> None:
        context.launch_configurations.pop(perform_substitutions(context, self.name), None)


@expose_action('reset')
class ResetLaunchConfigurations(Action):
    """Removes all launch configurations except the given ones."""

    def __init__(
        self, launch_configurations: dict[Any, SomeSubstitutions] | None = None, **options: Any
    ) -> None:
        super().__init__(**options)
        self._kept = dict(launch_configurations or {})

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        arguments['launch_configurations'] = _read_kept_configurations(entity, parser)
        return cls, arguments

    def execute(self, context: LaunchContext) -> None:
        kept = {
            perform_text(context, name): perform_text(context, value) for name, value in self._kept.items()
        }
        context.launch_configurations = kept


def _read_kept_configurations(entity: Entity, parser: Parser) -> dict[Any, Any]:
    """Return the launch configurations in a tag's `keep` children: values by name."""
    kept = {}
    for item in entity.get_entities('keep'):
        name = tuple(parser.parse_substitution(item.get_attr('name')))
        kept[name] = parser.parse_substitution(item.get_attr('value'))
        item.assert_entity_completely_parsed()
    return kept


# -- environment variables -----------------------------------------------------------------------------------


@expose_action('set_env')
class SetEnvironmentVariable(_Setting):
    """Sets an environment variable for the processes that start later in this scope."""

    def execute(self, context: LaunchContext) -> None:
        name = perform_substitutions(context, self.name)
        context.environment[name] = perform_substitutions(context, self.value)


@expose_action('unset_env')
class UnsetEnvironmentVariable(_Naming):
    """Removes an environment variable."""

    def execute(self, context: LaunchContext) -> None:
        context.environment.pop(perform_substitutions(context, self.name), None)


@expose_action('append_env')
class AppendEnvironmentVariable(_Setting):
    """Appends to the value of an environment variable or, with `prepend`, puts text before it."""

    def __init__(
        self,
        name: SomeSubstitutions,
        value: SomeSubstitutions,
        prepend: bool | SomeSubstitutions = False,
        separator: SomeSubstitutions = os.pathsep,
        **options: Any,
    ) -> None:
        super().__init__(name, value, **options)
        self._given_prepend = prepend
        self._prepend = normalize_to_list_of_substitutions(
            str(prepend).lower() if isinstance(prepend, bool) else prepend
        )
        self._separator = normalize_to_list_of_substitutions(separator)

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        prepend = entity.get_attr('prepend', optional=True, data_type=bool)
        if prepend is not None:
            arguments['prepend'] = (
                prepend if isinstance(prepend, bool) else parser.parse_substitution(prepend)
            )
        separator = entity.get_attr('separator', optional=True)
        if separator is not None:
            arguments['separator'] = parser.parse_substitution(separator)
        return cls, arguments

    @property
    def prepend(self) -> bool | list[Substitution]:
        """Whether the new text comes before the old value: a boolean, or substitutions that will give it."""
        return self._given_prepend if isinstance(self._given_prepend, bool) else self._prepend

    @property
    def separator(self) -> list[Substitution]:
        """The separator between the old value and the new text."""
        return self._separator

    def execute(self, context: LaunchContext) -> None:
        name = perform_substitutions(context, self.name)
        parts = [context.environment.get(name, ''), perform_substitutions(context, self.value)]
        if perform_substitutions(context, self._prepend).lower() in {'true', '1', 'yes', 'on'}:
            parts.reverse()
        separator = perform_substitutions(context, self._separator)
        context.environment[name] = separator.join(part for part in parts if part)


# -- scopes --------------------------------------------------------------------------------------------------


@expose_action('push_launch_configurations')
class PushLaunchConfigurations(Action):
    """Begins a scope of launch configurations."""

    def execute(self, context: LaunchContext) -> None:
        context.push_launch_configurations()


@expose_action('pop_launch_configurations')
class PopLaunchConfigurations(Action):
    """Ends a scope of launch configurations."""

    def execute(self, context: LaunchContext) -> None:
        context.pop_launch_configurations()


@expose_action('push_environment')
class PushEnvironment(Action):
    """Begins a scope of environment variables."""

    def execute(self, context: LaunchContext) -> None:
        context.push_environment()


@expose_action('pop_environment')
class PopEnvironment(Action):
    """Ends a scope of environment variables."""

    def execute(self, context: LaunchContext) -> None:
        context.pop_environment()


@expose_action('reset_environment')
class ResetEnvironment(Action):
    """Restores the environment that the launch began with."""

    def execute(self, context: LaunchContext) -> None:
        context.reset_environment()


@expose_action('group')
class GroupAction(Action):
    """Actions with a scope of their own for launch configurations and environment variables."""

    def __init__(
        self,
        actions: Iterable[LaunchDescriptionEntity],
        *,
        scoped: bool = True,
        forwarding: bool = True,
        launch_configurations: dict[Any, SomeSubstitutions] | None = None,
        **options: Any,
    ) -> None:
        super().__init__(**options)
        self._actions = list(actions)
        self._scoped = scoped
        self._forwarding = forwarding
        self._configurations = dict(launch_configurations or {})

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        for name in ('scoped', 'forwarding'):
            value = entity.get_attr(name, data_type=bool, optional=True, can_be_str=False)
            if value is not None:
                arguments[name] = value
        arguments['launch_configurations'] = _read_kept_configurations(entity, parser)
        arguments['actions'] = parser.parse_children(entity, skip={'keep'})
        return cls, arguments

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        sets: list[LaunchDescriptionEntity] = [
            SetLaunchConfiguration(name, value) for name, value in self._configurations.items()
        ]
        actions = entity_list(self._actions)
        if not self._scoped:
            return [*sets, *actions]
        if self._forwarding:
            inner = [*sets, *actions]
        else:
            inner = [ResetEnvironment(), ResetLaunchConfigurations(self._configurations), *actions]
        return [
            PushLaunchConfigurations(),
            PushEnvironment(),
            *inner,
            PopEnvironment(),
            PopLaunchConfigurations(),
        ]

    def describe_sub_entities(self) -> list[LaunchDescriptionEntity]:
        return [] if self.condition else entity_list(self._actions)

    def describe_conditional_sub_entities(self) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        return [('its condition holds', entity_list(self._actions))] if self.condition else []

    def execute(self, context: LaunchContext) -> Sequence[LaunchDescriptionEntity]:
        return self.get_sub_entities()

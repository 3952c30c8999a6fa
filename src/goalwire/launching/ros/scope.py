"""Actions that set namespace, parameters and remappings for the nodes that follow in the same scope."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

from goalwire.errors import LaunchError
from goalwire.launching.actions import TimerAction
from goalwire.launching.exposure import expose_action
from goalwire.launching.frontend import Entity, Parser, parse_texts
from goalwire.launching.model import Action, LaunchContext, SomeSubstitutions, Substitution
from goalwire.launching.output import logging_directory
from goalwire.launching.ros.namespaces import join_namespace
from goalwire.launching.ros.own_node import LaunchNode
from goalwire.launching.ros.parameters import ParameterFile, evaluate_dictionary
from goalwire.launching.values import (
    describe_text,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    perform_text,
)
from goalwire.rules.names import validate_namespace


@expose_action('push_ros_namespace', 'push-ros-namespace')
class PushROSNamespace(Action):
    """Puts a namespace before the namespaces of the nodes that follow."""

    def __init__(self, namespace: SomeSubstitutions, **options: Any) -> None:
        super().__init__(**options)
        self._namespace = normalize_to_list_of_substitutions(namespace)

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        return cls, arguments | parse_texts(entity, parser, 'namespace')

    @property
    def namespace(self) -> list[Substitution]:
        return self._namespace

    def describe(self) -> str:
        return f'{type(self).__name__}({describe_text(self._namespace)})'

    def execute(self, context: LaunchContext) -> None:
        pushed = perform_substitutions(context, self._namespace)
        found = join_namespace(context.launch_configurations.get('ros_namespace'), pushed)
        try:
            validate_namespace(found or '/')
        except ValueError as error:
            raise LaunchError(' '.join(str(error).split())) from error
        context.launch_configurations['ros_namespace'] = found


PushRosNamespace = PushROSNamespace


@expose_action('set_parameter')
class SetParameter(Action):
    """Gives a parameter to the nodes that follow."""

    def __init__(self, name: SomeSubstitutions, value: Any, **options: Any) -> None:
        super().__init__(**options)
        self._name = tuple(normalize_to_list_of_substitutions(name))
        self._value = value

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        return cls, arguments | parse_texts(entity, parser, 'name', 'value')

    @property
    def name(self) -> tuple[Substitution, ...]:
        return self._name

    @property
    def value(self) -> Any:
        return self._value

    def describe(self) -> str:
        return f'{type(self).__name__}({describe_text(self._name)})'

    def execute(self, context: LaunchContext) -> None:
        value = self._value
        if isinstance(value, list) and all(isinstance(item, Substitution) for item in value):
            value = tuple(value)
            if len(value) == 1:
                value = value[0]
        found = evaluate_dictionary(context, {self._name: value})
        _append(context, 'global_params', *found.items())


@expose_action('set_parameters_from_file')
class SetParametersFromFile(Action):
    """Gives a parameter file to the nodes that follow."""

    def __init__(self, filename: SomeSubstitutions | Path, **options: Any) -> None:
        super().__init__(**options)
        self._file = ParameterFile(filename)

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        return cls, arguments | parse_texts(entity, parser, 'filename')

    def execute(self, context: LaunchContext) -> None:
        path = self._file.evaluate(context)
        if not path.is_file():
            raise LaunchError(f'the parameter file {path} does not exist')
        _append(context, 'global_params', str(path.absolute()))


@expose_action('set_use_sim_time')
class SetUseSimTime(SetParameter):
    """Sets whether the nodes that follow take their time from /clock."""

    def __init__(self, value: Any, **options: Any) -> None:
        super().__init__('use_sim_time', value, **options)

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = Action.parse(entity, parser)
        return cls, arguments | parse_texts(entity, parser, 'value')


@expose_action('set_remap')
class SetRemap(Action):
    """Gives a remapping rule to the nodes that follow."""

    def __init__(self, src: SomeSubstitutions, dst: SomeSubstitutions, **options: Any) -> None:
        super().__init__(**options)
        self._src = normalize_to_list_of_substitutions(src)
        self._dst = normalize_to_list_of_substitutions(dst)

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        return cls, arguments | parse_texts(entity, parser, src='from', dst='to')

    @property
    def src(self) -> list[Substitution]:
        return self._src

    @property
    def dst(self) -> list[Substitution]:
        return self._dst

    def describe(self) -> str:
        return f'SetRemap({describe_text(self._src)}, {describe_text(self._dst)})'

    def execute(self, context: LaunchContext) -> None:
        rule = perform_substitutions(context, self._src), perform_substitutions(context, self._dst)
        _append(context, 'ros_remaps', rule)


@expose_action('set_ros_log_dir')
class SetROSLogDir(Action):
    """Sets the log folder of the nodes that follow. A relative path is below the current log folder."""

    def __init__(self, new_log_dir: SomeSubstitutions, **options: Any) -> None:
        super().__init__(**options)
        self._folder = normalize_to_list_of_substitutions(new_log_dir)

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        return cls, arguments | parse_texts(entity, parser, 'new_log_dir')

    @property
    def log_dir(self) -> list[Substitution]:
        return self._folder

    def execute(self, context: LaunchContext) -> None:
        wanted = perform_text(context, self._folder)
        context.environment['ROS_LOG_DIR'] = str(logging_directory() / Path(wanted).expanduser())


@expose_action('ros_timer')
class ROSTimer(TimerAction):
    """A TimerAction in ROS time: it follows /clock if `use_sim_time` is set in this scope."""

    _task: asyncio.Task[None] | None = None

    def _start(self, context: LaunchContext, seconds: float) -> None:
        self._task = LaunchNode.of(context).start(self._sleep(context, seconds))

    async def _sleep(self, context: LaunchContext, seconds: float) -> None:
        node = await LaunchNode.of(context).wait_open()
        for entry in context.launch_configurations.get('global_params', ()):
            if isinstance(entry, tuple) and entry[0] == 'use_sim_time':
                node.parameters['use_sim_time'] = entry[1]
        await node.clock.sleep(seconds)
        self.expire(context)

    def cancel(self) -> None:
        super().cancel()
        if self._task is not None:
            self._task.cancel()


def _append(context: LaunchContext, name: str, *items: object) -> None:
    """Append to a list of settings in this scope; the list of the enclosing scope stays unchanged."""
    context.launch_configurations[name] = [*context.launch_configurations.get(name, ()), *items]

"""The action that runs a node."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from goalwire.errors import LaunchError
from goalwire.launching.exposure import expose_action
from goalwire.launching.frontend import Entity, Parser
from goalwire.launching.model import Action, LaunchContext, SomeSubstitutions
from goalwire.launching.output import get_logger
from goalwire.launching.process import ExecuteProcess, parse_command_line
from goalwire.launching.ros.parameters import (
    Parameter,
    ParameterFile,
    SomeParameters,
    as_file,
    as_rule,
    evaluate_dictionary,
    parse_parameters,
    write_temporary,
)
from goalwire.launching.ros.substitutions import ExecutableInPackage
from goalwire.launching.values import (
    describe_text,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    perform_text,
)
from goalwire.rules.names import absolute_namespace, validate_namespace, validate_node_name

Remappings: TypeAlias = Iterable[tuple[SomeSubstitutions, SomeSubstitutions]]


@expose_action('node')
class Node(ExecuteProcess):
    """Runs a node: a package's program with a name, a namespace, parameters and remappings."""

    UNSPECIFIED_NODE_NAME = '<node_name_unspecified>'
    UNSPECIFIED_NODE_NAMESPACE = '<node_namespace_unspecified>'

    def __init__(
        self,
        *,
        executable: SomeSubstitutions,
        package: SomeSubstitutions | None = None,
        name: SomeSubstitutions | None = None,
        namespace: SomeSubstitutions | None = None,
        exec_name: SomeSubstitutions | None = None,
        parameters: SomeParameters | None = None,
        remappings: Remappings | None = None,
        ros_arguments: Iterable[SomeSubstitutions] | None = None,
        arguments: Iterable[SomeSubstitutions] | None = None,
        **options: Any,
    ) -> None:
        program = executable if package is None else ExecutableInPackage(executable, package)
        own = [*([] if ros_arguments is None else ['--ros-args', *ros_arguments])]
        if parameters is not None and (isinstance(parameters, str) or not isinstance(parameters, Sequence)):
            raise TypeError(
                f'Node expects its parameters as a list of mappings and files, got {parameters!r:.100}'
            )
        super().__init__(cmd=[program, *(arguments or ()), *own, '--ros-args'], name=exec_name, **options)
        self._package = package
        self._executable = executable
        self._name = name
        self._namespace = namespace
        self._parameters = list(parameters or ())
        self._remappings = [(source, target) for source, target in remappings or ()]
        self._expanded_name: str = self.UNSPECIFIED_NODE_NAME
        self._expanded_namespace: str = self.UNSPECIFIED_NODE_NAMESPACE
        self._full_name: str | None = None
        self._expanded_remappings: list[tuple[str, str]] | None = None

    @classmethod
    def parse(
        cls, entity: Entity, parser: Parser, ignore: Iterable[str] = ()
    ) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser, ignore=[*ignore, 'cmd', 'name'])
        texts = {'exec': 'executable', 'pkg': 'package', 'name': 'name', 'namespace': 'namespace'}
        texts['exec_name'] = 'exec_name'
        for attribute, argument in texts.items():
            if argument in ignore:
                continue
            value = entity.get_attr(attribute, optional=attribute != 'exec')
            if value is not None:
                arguments[argument] = parser.parse_substitution(value)
        for attribute, argument in {'args': 'arguments', 'ros_args': 'ros_arguments'}.items():
            value = entity.get_attr(attribute, optional=True)
            if value is not None:
                arguments[argument] = parse_command_line(value, parser)
        remaps = entity.get_entities('remap')
        if remaps:
            arguments['remappings'] = [
                (
                    parser.parse_substitution(remap.get_attr('from')),
                    parser.parse_substitution(remap.get_attr('to')),
                )
                for remap in remaps
            ]
        parameters = entity.get_entities('param')
        if parameters:
            arguments['parameters'] = parse_parameters(parameters, parser)
        for remap in remaps:
            remap.assert_entity_completely_parsed()
        return cls, arguments

    # --- what others read

    @property
    def node_package(self) -> SomeSubstitutions | None:
        return self._package

    @property
    def given_parameters(self) -> list[Any]:
        """The parameters as they stand in the file: mappings, files, paths."""
        return self._parameters

    @property
    def node_executable(self) -> SomeSubstitutions:
        return self._executable

    @property
    def node_name(self) -> str:
        """The full name, with markers for what the file leaves open. Raises LaunchError before execution."""
        if self._full_name is None:
            raise LaunchError("'node_name' is known once the action is executed")
        return self._full_name

    @property
    def expanded_node_namespace(self) -> str:
        return self._expanded_namespace

    @property
    def expanded_remapping_rules(self) -> list[tuple[str, str]] | None:
        return self._expanded_remappings

    def is_node_name_fully_specified(self) -> bool:
        return self.UNSPECIFIED_NODE_NAME not in self.node_name and (
            self.UNSPECIFIED_NODE_NAMESPACE not in self.node_name
        )

    def describe(self) -> str:
        parts = [] if self._package is None else [f'package={describe_text(self._package)}']
        parts.append(f'executable={describe_text(self._executable)}')
        if self._name is not None:
            parts.append(f'name={describe_text(self._name)}')
        if self._namespace is not None:
            parts.append(f'namespace={describe_text(self._namespace)}')
        return f'{type(self).__name__}({", ".join(parts)})'

    # --- carrying it out

    def execute(self, context: LaunchContext) -> Any:
        self.expand_names(context)
        done = super().execute(context)
        if not context.is_shutdown and self.is_node_name_fully_specified():
            counts = context.get_globals().get('unique_ros_node_names', {})
            counts[self.node_name] = counts.get(self.node_name, 0) + 1
            context.extend_globals({'unique_ros_node_names': counts})
            if counts[self.node_name] > 1:
                get_logger(str(self.name)).warning(
                    f'there are now at least {counts[self.node_name]} nodes with the name {self.node_name} '
                    'created within this launch context'
                )
        return done

    def expand_names(self, context: LaunchContext) -> None:
        """Find out name and namespace, once. Raises LaunchError for names that ROS 2 does not allow."""
        if self._full_name is not None:
            return
        try:
            if self._name is not None:
                self._expanded_name = perform_text(context, self._name)
                validate_node_name(self._expanded_name)
            own = None if self._namespace is None else perform_text(context, self._namespace)
            namespace = joined_namespace(context.launch_configurations.get('ros_namespace'), own)
            if namespace is not None:
                self._expanded_namespace = namespace
                validate_namespace(namespace)
        except ValueError as error:
            raise LaunchError(' '.join(str(error).split())) from error
        self._full_name = f'{self._expanded_namespace.rstrip("/")}/{self._expanded_name}'

    def command(self, context: LaunchContext) -> list[str]:
        """The program with its own arguments, then name, namespace, parameters and remappings for ROS."""
        cmd = super().command(context)
        if self._name is not None:
            cmd += ['-r', f'__node:={self._expanded_name}']
        if self._expanded_namespace != self.UNSPECIFIED_NODE_NAMESPACE:
            cmd += ['-r', f'__ns:={self._expanded_namespace}']
        for entry in context.launch_configurations.get('global_params', ()):
            cmd += ['-p', as_rule(*entry)] if isinstance(entry, tuple) else ['--params-file', str(entry)]
        for item in self._parameters:
            cmd += self._parameter_arguments(context, item)
        remappings = list(context.launch_configurations.get('ros_remaps', ()))
        remappings += [
            (perform_text(context, source), perform_text(context, target))
            for source, target in self._remappings
        ]
        self._expanded_remappings = remappings or None
        for source, target in remappings:
            cmd += ['-r', f'{source}:={target}']
        return cmd

    def _parameter_arguments(self, context: LaunchContext, item: Any) -> list[str]:
        if isinstance(item, Parameter):
            return ['-p', as_rule(*item.evaluate(context))]
        if isinstance(item, Mapping):
            found = evaluate_dictionary(context, item)
            if not found:
                return []
            node = self.node_name if self.is_node_name_fully_specified() else '/**'
            return ['--params-file', str(write_temporary(context, as_file(node, found)))]
        if isinstance(item, ParameterFile):
            path = item.evaluate(context)
        else:
            path = Path(perform_substitutions(context, normalize_to_list_of_substitutions(item)))
        if not path.is_file():
            get_logger('launch_ros').warning(f'Parameter file path is not a file: {path}')
            return []
        return ['--params-file', str(path)]


def joined_namespace(base: str | None, own: str | None) -> str | None:
    """A namespace below another, absolute; None where there is neither. An absolute one stands alone."""
    if own is None:
        return base
    joined = own if not base or own.startswith('/') else f'{base.rstrip("/")}/{own}'
    return absolute_namespace(joined.rstrip('/'))

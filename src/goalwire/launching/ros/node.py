"""The action that runs a node."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from goalwire.errors import LaunchError, NoSuchPackageError
from goalwire.launching import packages
from goalwire.launching.execute_process import ExecuteProcess, parse_command_line
from goalwire.launching.exposure import expose_action
from goalwire.launching.frontend import Entity, Parser
from goalwire.launching.model import Action, LaunchContext, SomeSubstitutions, Substitution
from goalwire.launching.output import get_logger
from goalwire.launching.ros.missing_containers import CPP_ADVICE, CPP_CONTAINERS, note_missing_container
from goalwire.launching.ros.namespaces import join_namespace
from goalwire.launching.ros.node_names import add_node_name, get_node_name_count
from goalwire.launching.ros.parameters import (
    Parameter,
    SomeParameters,
    as_file,
    as_rule,
    evaluate_dictionary,
    normalize_parameters,
    parse_parameters,
    write_temporary,
)
from goalwire.launching.ros.remappings import SomeRemapRules, normalize_remap_rules, parse_remappings
from goalwire.launching.ros.substitutions import ExecutableInPackage
from goalwire.launching.values import (
    describe_text,
    normalize_to_list_of_substitutions,
    perform_text,
)
from goalwire.rules.names import validate_namespace, validate_node_name


class _NameRule(Substitution):
    """A remapping rule for a node's name or namespace; the name is evaluated later than the command."""

    def __init__(self, key: str, value: Callable[[], str]) -> None:
        self._key = key
        self._value = value

    def describe(self) -> str:
        return f"'{self._key}:={self._value()}'"

    def perform(self, context: LaunchContext) -> str:
        return f'{self._key}:={self._value()}'


def warn_of_twins(context: LaunchContext, node_name: str, logger: str) -> None:
    """Warn if the launch has started several nodes with this full name."""
    if (count := get_node_name_count(context, node_name)) > 1:
        get_logger(logger).warning(
            f'there are now at least {count} nodes with the name {node_name} '
            'created within this launch context'
        )


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
        remappings: SomeRemapRules | None = None,
        ros_arguments: Iterable[SomeSubstitutions] | None = None,
        arguments: Iterable[SomeSubstitutions] | None = None,
        **options: Any,
    ) -> None:
        program = executable if package is None else ExecutableInPackage(executable, package)
        own = [*([] if ros_arguments is None else ['--ros-args', *ros_arguments])]
        rule: list[SomeSubstitutions] = []
        if name is not None:
            rule = ['-r', _NameRule('__node', lambda: self._expanded_name)]
        cmd: list[SomeSubstitutions] = [program, *(arguments or ()), *own, '--ros-args', *rule]
        super().__init__(cmd=cmd, name=exec_name, **options)
        self._package = package
        self._executable = executable
        self._name = name
        self._namespace = namespace
        self._parameters = [] if parameters is None else list(normalize_parameters(parameters))
        self._remappings = list(normalize_remap_rules(remappings or ()))
        self._expanded_name: str = self.UNSPECIFIED_NODE_NAME
        self._expanded_namespace: str = self.UNSPECIFIED_NODE_NAMESPACE
        self._full_name: str | None = None
        self._expanded_remappings: list[tuple[str, str]] | None = None
        self._has_ros_arguments = False

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
            arguments['remappings'] = parse_remappings(remaps, parser)
        parameters = entity.get_entities('param')
        if parameters:
            arguments['parameters'] = parse_parameters(parameters, parser)
        return cls, arguments

    # --- read by users

    @property
    def node_package(self) -> SomeSubstitutions | None:
        return self._package

    @property
    def given_parameters(self) -> list[Any]:
        """The node's parameters, not yet evaluated, as the launch file gives them: mappings, files, paths."""
        return self._parameters

    @property
    def node_executable(self) -> SomeSubstitutions:
        return self._executable

    @property
    def node_name(self) -> str:
        """The node's full name, with placeholders for missing parts. Raises LaunchError before execution."""
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

    # --- execution

    def execute(self, context: LaunchContext) -> Any:
        if not context.is_shutdown and self._is_missing_container(context):
            self.expand_names(context)
            note_missing_container(context, self.node_name, self)
            get_logger('launch_ros').warning(f'container {self.node_name}: skipped. {CPP_ADVICE}')
            return None
        return self.start(context)

    def start(self, context: LaunchContext, program: list[str] | None = None) -> Any:
        """Start the node's process; `program` replaces the program that the launch file names."""
        if program is not None:
            self.cmd[:1] = [normalize_to_list_of_substitutions(word) for word in program]
        self._perform_substitutions(context)
        done = super().execute(context)
        if not context.is_shutdown and self.is_node_name_fully_specified():
            add_node_name(context, self.node_name)
            warn_of_twins(context, self.node_name, str(self.name))
        return done

    def may_lack_program(self, context: LaunchContext) -> bool:
        """Return whether a missing program is only skipped, as that of C++ containers is."""
        return self._is_missing_container(context)

    def _is_missing_container(self, context: LaunchContext) -> bool:
        """Return whether the program is ROS 2's container for C++ components, and is not installed."""
        if self._package is None or perform_text(context, self._package) != CPP_CONTAINERS:
            return False
        try:
            packages.prefix(CPP_CONTAINERS)
        except NoSuchPackageError:
            return True
        return False

    def expand_names(self, context: LaunchContext) -> None:
        """Evaluate the node's name and namespace, once. Raises LaunchError for names that ROS 2 forbids."""
        if self._full_name is not None:
            return
        try:
            if self._name is not None:
                self._expanded_name = perform_text(context, self._name)
                validate_node_name(self._expanded_name)
            own = None if self._namespace is None else perform_text(context, self._namespace)
            namespace = join_namespace(context.launch_configurations.get('ros_namespace'), own)
            if namespace is not None:
                self._expanded_namespace = namespace
                validate_namespace(namespace)
        except ValueError as error:
            raise LaunchError(' '.join(str(error).split())) from error
        self._full_name = f'{self._expanded_namespace.rstrip("/")}/{self._expanded_name}'

    def _perform_substitutions(self, context: LaunchContext) -> None:
        """Evaluate the node's names, and append its ROS arguments to the command; only once."""
        if self._has_ros_arguments:
            return
        self.expand_names(context)
        words: list[str | Substitution] = []
        if self._expanded_namespace != self.UNSPECIFIED_NODE_NAMESPACE:
            words += ['-r', _NameRule('__ns', lambda: self._expanded_namespace)]
        for entry in context.launch_configurations.get('global_params', ()):
            words += ['-p', as_rule(*entry)] if isinstance(entry, tuple) else ['--params-file', str(entry)]
        for item in self._parameters:
            words += self._parameter_arguments(context, item)
        remappings = list(context.launch_configurations.get('ros_remaps', ()))
        remappings += [
            (perform_text(context, source), perform_text(context, target))
            for source, target in self._remappings
        ]
        self._expanded_remappings = remappings or None
        for source, target in remappings:
            words += ['-r', f'{source}:={target}']
        self.cmd.extend(normalize_to_list_of_substitutions(word) for word in words)
        self._has_ros_arguments = True

    def _parameter_arguments(self, context: LaunchContext, item: Any) -> list[str]:
        if isinstance(item, Parameter):
            return ['-p', as_rule(*item.evaluate(context))]
        if isinstance(item, Mapping):
            found = evaluate_dictionary(context, item)
            if not found:
                return []
            node = self.node_name if self.is_node_name_fully_specified() else '/**'
            return ['--params-file', str(write_temporary(context, as_file(node, found)))]
        path = item.evaluate(context)
        if not path.is_file():
            get_logger('launch_ros').warning(f'Parameter file path is not a file: {path}')
            return []
        return ['--params-file', str(path)]

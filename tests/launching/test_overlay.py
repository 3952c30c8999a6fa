"""launch, launch_ros, launch_xml and launch_yaml under the names that launch files import."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.patience import PATIENCE

MODULES = """
launch: LaunchDescription LaunchService LaunchContext Action Substitution LaunchIntrospector
launch: SomeSubstitutionsType
launch: Condition Event EventHandler LaunchDescriptionEntity LaunchDescriptionSource SomeActionsType
launch.action: Action
launch.actions: AppendEnvironmentVariable DeclareLaunchArgument EmitEvent ExecuteLocal ExecuteProcess
launch.actions: ForEach ForLoop
launch.actions: GroupAction IncludeLaunchDescription LogInfo OpaqueCoroutine OpaqueFunction PopEnvironment
launch.actions: Log
launch.actions: PopLaunchConfigurations PushEnvironment PushLaunchConfigurations RegisterEventHandler
launch.actions: ResetEnvironment
launch.actions: ResetLaunchConfigurations SetEnvironmentVariable SetLaunchConfiguration Shutdown TimerAction
launch.actions: UnregisterEventHandler UnsetEnvironmentVariable UnsetLaunchConfiguration
launch.actions.declare_launch_argument: DeclareLaunchArgument
launch.actions.execute_process: ExecuteProcess
launch.actions.shutdown_action: Shutdown
launch.conditions: IfCondition UnlessCondition LaunchConfigurationEquals LaunchConfigurationNotEquals
launch.conditions.if_condition: IfCondition
launch.event_handlers: OnExecutionComplete OnProcessExit OnProcessIO OnProcessStart OnShutdown
launch.event_handlers.on_process_exit: OnProcessExit
launch.events: Shutdown TimerEvent ExecutionComplete matches_action
launch.events.process: ProcessStarted ProcessExited ProcessIO ShutdownProcess SignalProcess ProcessStdout
launch.events.process: matches_pid
launch.frontend: Entity Parser expose_action expose_substitution
launch.frontend.parse_substitution: parse_substitution
launch.launch_context: LaunchContext
launch.launch_description: LaunchDescription
launch.launch_description_entity: LaunchDescriptionEntity
launch.launch_description_sources: AnyLaunchDescriptionSource FrontendLaunchDescriptionSource
launch.launch_description_sources: PythonLaunchDescriptionSource get_launch_description_from_any_launch_file
launch.launch_description_sources.python_launch_description_source: PythonLaunchDescriptionSource
launch.launch_service: LaunchService
launch.logging.handlers: Handler FileHandler RotatingFileHandler
launch.logging: get_logger launch_config
launch.some_substitutions_type: SomeSubstitutionsType SomeSubstitutionsType_types_tuple
launch.some_entities_type: SomeEntitiesType
launch.substitution: Substitution
launch.substitutions: AndSubstitution AnySubstitution AllSubstitution AnonName Command EnvironmentVariable
launch.substitutions: EqualsSubstitution FileContent FindExecutable IfElseSubstitution LaunchConfiguration
launch.substitutions: LaunchLogDir LocalSubstitution NotEqualsSubstitution NotSubstitution OrSubstitution
launch.substitutions: PathJoinSubstitution PathSubstitution PythonExpression StringJoinSubstitution
launch.substitutions: TextSubstitution
launch.substitutions: ThisLaunchFile ThisLaunchFileDir SubstitutionFailure
launch.substitutions.launch_configuration: LaunchConfiguration
launch.substitutions.path_join_substitution: PathJoinSubstitution
launch.utilities: normalize_to_list_of_substitutions perform_substitutions ensure_argument_type
launch.utilities: AsyncSafeSignalManager visit_all_entities_and_collect_futures is_a isclassinstance
launch.utilities.class_tools_impl: is_a is_a_subclass isclassinstance
launch.utilities.type_utils: coerce_list extract_type get_typed_value is_instance_of is_valid_scalar_type
launch.utilities.type_utils: perform_typed_substitution normalize_typed_substitution
launch_ros.actions: Node LifecycleNode LifecycleTransition PushRosNamespace PushROSNamespace SetParameter
launch_ros.actions: SetRemap
launch_ros.actions: SetParametersFromFile SetUseSimTime SetROSLogDir RosTimer ComposableNodeContainer
launch_ros.actions: LoadComposableNodes ROSTimer
launch_ros.actions.load_composable_nodes: LoadComposableNodes get_composable_node_load_request
launch_ros.actions.push_ros_namespace: PushROSNamespace PushRosNamespace
launch_ros.actions.ros_timer: ROSTimer
launch_ros.actions.set_ros_log_dir: SetROSLogDir
launch_ros.ros_adapters: ROSAdapter get_ros_adapter get_ros_node
launch_ros.utilities: add_node_name evaluate_parameter_dict evaluate_parameters get_node_name_count
launch_ros.utilities: is_namespace_absolute is_root_namespace make_namespace_absolute normalize_parameters
launch_ros.utilities: normalize_parameter_dict normalize_remap_rule normalize_remap_rules prefix_namespace
launch_ros.utilities: to_parameters_list
launch_ros.actions.node: Node
launch_ros.descriptions: ComposableNode Parameter ParameterFile ParameterValue
launch_ros.event_handlers: OnStateTransition
launch_ros.events.lifecycle: ChangeState StateTransition matches_node_name
launch_ros.events.matchers: matches_node_name
launch_ros.parameter_descriptions: Parameter ParameterFile ParameterValue
launch_ros.parameters_type: SomeParameters
launch_ros.remap_rule_type: SomeRemapRules
launch_ros.substitutions: ExecutableInPackage FindPackage FindPackagePrefix FindPackageShare Parameter
launch.launch_description_sources.any_launch_file_utilities: get_launch_description_from_any_launch_file
launch.launch_description_sources.python_launch_file_utilities: load_python_launch_file_as_module
launch_xml: Entity Parser
launch_xml.launch_description_sources: XMLLaunchDescriptionSource
launch_yaml: Entity Parser
launch_yaml.launch_description_sources: YAMLLaunchDescriptionSource
"""


@pytest.mark.parametrize('line', MODULES.strip().splitlines())
def test_every_name_is_where_launch_files_import_it_from(line: str) -> None:
    module, _, names = line.partition(': ')
    found = importlib.import_module(module)
    assert [name for name in names.split() if not hasattr(found, name)] == []


def test_modules_are_attributes_too() -> None:
    import launch
    import launch_ros

    assert issubclass(launch.events.process.ShutdownProcess, launch.Event)
    assert launch.events.matchers.matches_action  # type: ignore[attr-defined]
    assert issubclass(launch_ros.events.lifecycle.ChangeState, launch.Event)
    assert launch.substitutions.launch_configuration  # type: ignore[attr-defined]


def test_a_sourced_ros_2_comes_first(tmp_path: Path) -> None:
    for name in ('launch', 'launch_ros'):
        (tmp_path / name).mkdir()
        (tmp_path / name / '__init__.py').write_text('REAL = True\n')
    done = subprocess.run(
        [sys.executable, '-c', 'import launch, launch_ros; print(launch.REAL and launch_ros.REAL)'],
        env={**os.environ, 'PYTHONPATH': str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == 'True\n'


@pytest.mark.parametrize('front', ['launch.frontend', 'launch_xml'])
def test_a_front_end_knows_every_tag_by_itself(front: str, tmp_path: Path) -> None:
    file = tmp_path / 'talker.launch.xml'
    file.write_text('<launch><node pkg="demo" exec="talker" name="$(env HOME)"/></launch>')
    program = f'from {front} import Parser; import sys\n'
    program += 'root, parser = Parser.load(sys.argv[1])\n'
    program += 'print(*[type(action).__name__ for action in parser.parse_description(root).entities])\n'
    done = subprocess.run(
        [sys.executable, '-c', program, file], capture_output=True, text=True, check=True, timeout=PATIENCE
    )
    assert done.stdout == 'Node\n'


def test_a_script_launches_by_itself(tmp_path: Path) -> None:
    """As people write it in the last lines of a launch file."""
    script = tmp_path / 'self.launch.py'
    script.write_text(
        'import sys\n'
        'from launch import LaunchDescription, LaunchService\n'
        'from launch.actions import ExecuteProcess\n'
        'def generate_launch_description():\n'
        '    return LaunchDescription([ExecuteProcess(cmd=["echo", "hello"], output="screen")])\n'
        'if __name__ == "__main__":\n'
        '    service = LaunchService(argv=sys.argv[1:])\n'
        '    service.include_launch_description(generate_launch_description())\n'
        '    sys.exit(service.run())\n'
    )
    done = subprocess.run(
        [sys.executable, script],
        env={**os.environ, 'ROS_LOG_DIR': str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert '[echo-1] hello\n' in done.stdout
    assert done.stderr == ''

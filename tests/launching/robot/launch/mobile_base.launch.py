"""A mobile robot with navigation, composed as those of turtlebot3 and nav2 are."""

import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    GroupAction,
    LogInfo,
    RegisterEventHandler,
    SetEnvironmentVariable,
)
from launch.conditions import IfCondition, LaunchConfigurationEquals
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import (
    AndSubstitution,
    AnySubstitution,
    Command,
    EnvironmentVariable,
    EqualsSubstitution,
    IfElseSubstitution,
    LaunchConfiguration,
    NotEqualsSubstitution,
    NotSubstitution,
    PathJoinSubstitution,
    PythonExpression,
    TextSubstitution,
)
from launch_ros.actions import LoadComposableNodes, Node, PushRosNamespace, SetParameter, SetRemap
from launch_ros.descriptions import ComposableNode, ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    share = get_package_share_directory('demo_robot')
    namespace = LaunchConfiguration('namespace')
    model = LaunchConfiguration('model')
    slam = LaunchConfiguration('slam')
    map_file = LaunchConfiguration('map')
    use_composition = LaunchConfiguration('use_composition')
    log_level = LaunchConfiguration('log_level')
    remappings = [('/tf', 'tf'), ('/tf_static', 'tf_static')]
    configured = ParameterFile(LaunchConfiguration('params_file'), allow_substs=True)
    urdf = PathJoinSubstitution([FindPackageShare('demo_robot'), 'config', [model, '.urdf']])

    arguments = [
        DeclareLaunchArgument('namespace', default_value='', description='Top-level namespace'),
        DeclareLaunchArgument('use_namespace', default_value='false'),
        DeclareLaunchArgument(
            'model',
            default_value=EnvironmentVariable('DEMO_MODEL', default_value='burger'),
            choices=['burger', 'waffle'],
            description='Which robot',
        ),
        DeclareLaunchArgument('slam', default_value='False', description='Make a map'),
        DeclareLaunchArgument('map', default_value=''),
        DeclareLaunchArgument('use_sim_time', default_value='false'),
        DeclareLaunchArgument('params_file', default_value=os.path.join(share, 'config', 'params.yaml')),
        DeclareLaunchArgument('use_composition', default_value='False'),
        DeclareLaunchArgument('use_respawn', default_value='False'),
        DeclareLaunchArgument('camera', default_value='false'),
        DeclareLaunchArgument('log_level', default_value=TextSubstitution(text='info')),
    ]
    nodes = GroupAction(
        condition=IfCondition(PythonExpression(['not ', use_composition])),
        actions=[
            PushRosNamespace(
                condition=IfCondition(LaunchConfiguration('use_namespace')), namespace=namespace
            ),
            SetParameter('use_sim_time', LaunchConfiguration('use_sim_time')),
            SetRemap(src='scan', dst='front/scan'),
            Node(
                package='demo_robot',
                executable='state_publisher',
                name='state_publisher',
                output='both',
                parameters=[{'robot_description': ParameterValue(Command(['cat ', urdf]), value_type=str)}],
                remappings=remappings,
            ),
            Node(
                condition=IfCondition(slam),
                package='demo_robot',
                executable='planner',
                name='slam',
                parameters=[configured],
                arguments=['--ros-args', '--log-level', log_level],
            ),
            Node(
                condition=IfCondition(
                    AndSubstitution(NotSubstitution(slam), NotEqualsSubstitution(map_file, ''))
                ),
                package='demo_robot',
                executable='plain',
                name='map_server',
                parameters=[{'yaml_filename': map_file}],
            ),
            Node(
                condition=IfCondition(
                    AnySubstitution(EqualsSubstitution(model, 'waffle'), LaunchConfiguration('camera'))
                ),
                package='demo_robot',
                executable='camera',
                namespace='head',
            ),
            Node(
                package='demo_robot',
                executable='controller',
                name=[TextSubstitution(text='controller_'), model],
                respawn=LaunchConfiguration('use_respawn'),
                respawn_delay=2.0,
                parameters=[
                    configured,
                    {
                        'wheel_separation': PythonExpression(
                            ["0.16 if '", model, "' == 'burger' else 0.287"]
                        ),
                        'mode': IfElseSubstitution(slam, 'mapping', 'driving'),
                        'plugins': ['static_layer', 'voxel_layer'],
                    },
                ],
                remappings=remappings,
            ),
        ],
    )
    composed = GroupAction(
        condition=IfCondition(use_composition),
        actions=[
            LoadComposableNodes(
                target_container='container',
                composable_node_descriptions=[
                    ComposableNode(package='demo_robot', plugin='demo::Planner', name='planner')
                ],
            )
        ],
    )
    spawner = Node(package='demo_robot', executable='short', arguments=['-entity', model], output='screen')
    driver = Node(package='demo_robot', executable='driver', name='driver')

    return LaunchDescription(
        [
            SetEnvironmentVariable('DEMO_BUFFERED', '1'),
            *arguments,
            nodes,
            composed,
            LogInfo(msg=['a small one: ', model], condition=LaunchConfigurationEquals('model', 'burger')),
            spawner,
            RegisterEventHandler(
                OnProcessExit(target_action=spawner, on_exit=[LogInfo(msg=['spawned ', model]), driver])
            ),
            RegisterEventHandler(
                OnProcessExit(
                    target_action=driver, on_exit=[EmitEvent(event=Shutdown(reason='the driver has ended'))]
                )
            ),
        ]
    )

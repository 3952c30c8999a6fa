"""A robot's bring-up as people write it: arguments, includes, a namespace, conditions."""

import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription
from launch.conditions import IfCondition, UnlessCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, PythonExpression
from launch_ros.actions import Node, PushRosNamespace, SetParameter
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    bringup_dir = get_package_share_directory('demo_robot')
    namespace = LaunchConfiguration('namespace')
    use_sim_time = LaunchConfiguration('use_sim_time')
    use_camera = LaunchConfiguration('use_camera')

    declare_namespace = DeclareLaunchArgument(
        'namespace', default_value='robot', description='Top-level namespace'
    )
    declare_use_sim_time = DeclareLaunchArgument(
        'use_sim_time', default_value='false', choices=['true', 'false'], description='Use /clock'
    )
    declare_use_camera = DeclareLaunchArgument('use_camera', default_value='true')
    declare_params = DeclareLaunchArgument(
        'params_file', default_value=os.path.join(bringup_dir, 'config', 'params.yaml')
    )

    group = GroupAction(
        [
            PushRosNamespace(namespace),
            SetParameter('use_sim_time', use_sim_time),
            Node(
                package='demo_robot',
                executable='state_publisher',
                name='state_publisher',
                output='screen',
                parameters=[LaunchConfiguration('params_file'), {'publish_frequency': 30.0}],
                remappings=[('/tf', 'tf'), ('/tf_static', 'tf_static')],
            ),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(os.path.join(bringup_dir, 'launch', 'sensors.launch.py')),
                launch_arguments={'camera': use_camera, 'lidar_port': '/dev/ttyUSB0'}.items(),
            ),
            IncludeLaunchDescription(
                PathJoinSubstitution([FindPackageShare('demo_robot'), 'launch', 'navigation.launch.xml']),
                launch_arguments=[('speed', '0.5')],
            ),
        ]
    )
    teleop = Node(
        package='demo_robot',
        executable='teleop',
        arguments=['--device', '0'],
        condition=IfCondition(PythonExpression(["'", namespace, "' == 'robot' and not ", 'False'])),
    )
    never = Node(package='demo_robot', executable='never', condition=UnlessCondition(use_camera))

    ld = LaunchDescription()
    ld.add_action(declare_namespace)
    ld.add_action(declare_use_sim_time)
    ld.add_action(declare_use_camera)
    ld.add_action(declare_params)
    ld.add_action(group)
    ld.add_action(teleop)
    ld.add_action(never)
    return ld

import os

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, SetEnvironmentVariable
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PythonExpression
from launch_ros.actions import Node, PushRosNamespace, SetRemap


def generate_launch_description():
    namespace = LaunchConfiguration('namespace')
    rviz = LaunchConfiguration('use_rviz')
    with open(os.path.join(os.path.dirname(__file__), 'arm.urdf')) as file:
        description = file.read()
    tf = [('/tf', 'tf'), ('/tf_static', 'tf_static')]
    return LaunchDescription(
        [
            SetEnvironmentVariable('RCUTILS_LOGGING_BUFFERED_STREAM', '1'),
            DeclareLaunchArgument('namespace', default_value='robot1'),
            DeclareLaunchArgument('use_rviz', default_value='True'),
            GroupAction(
                [
                    PushRosNamespace(
                        condition=IfCondition(PythonExpression(["'", namespace, "' != ''"])),
                        namespace=namespace,
                    ),
                    SetRemap('/unused', 'unused'),
                    Node(
                        package='robot_state_publisher',
                        executable='robot_state_publisher',
                        parameters=[{'robot_description': description, 'frame_prefix': 'robot1/'}],
                        remappings=tf,
                        output='screen',
                    ),
                    Node(
                        package='joint_state_publisher',
                        executable='joint_state_publisher',
                        parameters=[{'rate': 30}],
                    ),
                    Node(
                        package='rqt_graph',
                        executable='rqt_graph',
                        arguments=['--port', '0', '--no-open'],
                        condition=IfCondition(rviz),
                        output='screen',
                    ),
                ]
            ),
            Node(
                package='tf2_ros',
                executable='tf2_echo',
                arguments=['robot1/base', 'robot1/forearm', '20'],
                remappings=[('/tf', '/robot1/tf'), ('/tf_static', '/robot1/tf_static')],
                output='screen',
            ),
        ]
    )

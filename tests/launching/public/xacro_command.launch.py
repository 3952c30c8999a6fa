from launch import LaunchDescription
from launch.substitutions import Command, PathJoinSubstitution, ThisLaunchFileDir
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description():
    model = PathJoinSubstitution([ThisLaunchFileDir(), 'arm.urdf.xacro'])
    description = ParameterValue(Command(['xacro ', model, ' height:=0.75']), value_type=str)
    return LaunchDescription(
        [
            Node(
                package='robot_state_publisher',
                executable='robot_state_publisher',
                parameters=[{'robot_description': description}],
            ),
            Node(
                package='tf2_ros', executable='tf2_echo', arguments=['base', 'forearm', '20'], output='screen'
            ),
        ]
    )

from launch import LaunchDescription
from launch.actions import GroupAction
from launch_ros.actions import Node, PushRosNamespace


def generate_launch_description():
    return LaunchDescription(
        [
            GroupAction(
                [
                    PushRosNamespace('robot1'),
                    Node(package='examples_rclpy_minimal_publisher', executable='publisher_member_function'),
                    Node(
                        package='examples_rclpy_minimal_subscriber',
                        executable='subscriber_member_function',
                        output='screen',
                    ),
                ]
            )
        ]
    )

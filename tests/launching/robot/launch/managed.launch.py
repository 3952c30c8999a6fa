"""A managed node that is configured, and activated once it is inactive."""

import lifecycle_msgs.msg
from launch import LaunchDescription
from launch.actions import EmitEvent, LogInfo, RegisterEventHandler
from launch.events import matches_action
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState


def generate_launch_description():
    driver = LifecycleNode(
        package='demo_robot', executable='managed', name='driver', namespace='arm', output='screen'
    )
    configure = EmitEvent(
        event=ChangeState(
            lifecycle_node_matcher=matches_action(driver),
            transition_id=lifecycle_msgs.msg.Transition.TRANSITION_CONFIGURE,
        )
    )
    activate = RegisterEventHandler(
        OnStateTransition(
            target_lifecycle_node=driver,
            goal_state='inactive',
            entities=[
                LogInfo(msg=['activating ', LaunchConfiguration('who', default='it')]),
                EmitEvent(
                    event=ChangeState(
                        lifecycle_node_matcher=matches_action(driver),
                        transition_id=lifecycle_msgs.msg.Transition.TRANSITION_ACTIVATE,
                    )
                ),
            ],
        )
    )
    active = RegisterEventHandler(
        OnStateTransition(
            target_lifecycle_node=driver, goal_state='active', entities=[LogInfo(msg='it is active')]
        )
    )
    return LaunchDescription([activate, active, driver, configure])

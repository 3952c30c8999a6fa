import os

from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription, LogInfo
from launch.launch_description_sources import AnyLaunchDescriptionSource, PythonLaunchDescriptionSource


def generate_launch_description():
    here = os.path.dirname(__file__)
    return LaunchDescription(
        [
            IncludeLaunchDescription(
                AnyLaunchDescriptionSource(os.path.join(here, 'talker_listener.launch.xml')),
                launch_arguments={'topic': '/renamed'}.items(),
            ),
            IncludeLaunchDescription(PythonLaunchDescriptionSource([here, '/static_frames.launch.py'])),
            LogInfo(msg='all included'),
        ]
    )

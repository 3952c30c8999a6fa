"""The humanoid's servers, and with mission:=true also a mission.

ros2 launch humanoid humanoid.launch.py
ros2 launch humanoid humanoid.launch.py mission:=true namespace:=h1
ros2 launch humanoid humanoid.launch.py namespace:=h2 map_frame:=map place:='[0.0, -1.5, 0.0]'
ros2 launch humanoid humanoid.launch.py world:=house
ros2 launch humanoid humanoid.launch.py physics:=true use_sim_time:=true
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, Shutdown
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import LaunchConfiguration, PythonExpression
from launch_ros.actions import Node, PushRosNamespace, SetParameter
from launch_ros.parameter_descriptions import ParameterValue

from humanoid.description import urdf_path
from humanoid.servers import BASED, FRAMED, IN_WORLD, SERVERS, SIMULATED, SIMULATION, VIEWED


def generate_launch_description() -> LaunchDescription:
    # Robots share /tf, so a robot with a namespace puts it before the names of its frames.
    prefix = PythonExpression(["'", LaunchConfiguration('namespace'), "/'.lstrip('/')"])
    arguments = [
        DeclareLaunchArgument('namespace', default_value='', description='Namespace of all nodes'),
        DeclareLaunchArgument(
            'frame_prefix', default_value=prefix, description='Before the names of all frames'
        ),
        DeclareLaunchArgument('map_frame', default_value='', description='The frame that odom lies in'),
        DeclareLaunchArgument(
            'place',
            default_value='[0.0, 0.0, 0.0]',
            description='Where it lies there: x, y in m, a turn in rad',
        ),
        DeclareLaunchArgument('physics', default_value='false', description='Simulate the body by MuJoCo'),
        DeclareLaunchArgument(
            'world', default_value='', description='house, flat or a file: what is around it'
        ),
        DeclareLaunchArgument('use_sim_time', default_value='false', description='Take the time from /clock'),
        DeclareLaunchArgument('mission', default_value='false', description='Run a mission, and end with it'),
        DeclareLaunchArgument('log_level', default_value='info', description='Log level of all nodes'),
    ]
    level = ['--log-level', LaunchConfiguration('log_level')]
    physics = LaunchConfiguration('physics')
    framed = {'frame_prefix': ParameterValue(LaunchConfiguration('frame_prefix'), value_type=str)}
    placed = {
        'map_frame': ParameterValue(LaunchConfiguration('map_frame'), value_type=str),
        'place': ParameterValue(LaunchConfiguration('place')),
    }
    world = LaunchConfiguration('world')
    in_world = {'world': ParameterValue(world, value_type=str)}
    servers = [
        Node(
            package=VIEWED if name == VIEWED else 'humanoid',
            executable=name,
            name=name,
            output='screen',
            arguments=[str(urdf_path())] if name == VIEWED else [],
            ros_arguments=level,
            parameters=[
                *([framed] if name in FRAMED else ()),
                *([placed, in_world] if name in BASED else ()),
            ],
            condition=UnlessCondition(physics) if name in SIMULATED else None,
        )
        for name in SERVERS
    ]
    simulation = Node(  # without a name: it has several nodes in one process
        package='humanoid',
        executable=SIMULATION,
        output='screen',
        ros_arguments=level,
        parameters=[framed, placed, in_world],
        condition=IfCondition(physics),
    )
    around = [
        Node(
            package='humanoid',
            executable=name,
            name=name,
            output='screen',
            ros_arguments=level,
            parameters=[framed, in_world],
            condition=IfCondition(PythonExpression(["'", world, "' != ''"])),
        )
        for name in IN_WORLD
    ]
    mission = Node(
        package='humanoid',
        executable='mission',
        output='screen',
        ros_arguments=level,
        condition=IfCondition(LaunchConfiguration('mission')),
        on_exit=Shutdown(reason='the mission is over'),
    )
    scope = [
        PushRosNamespace(LaunchConfiguration('namespace')),
        SetParameter('use_sim_time', LaunchConfiguration('use_sim_time')),
    ]
    return LaunchDescription([*arguments, GroupAction([*scope, simulation, *servers, *around, mission])])

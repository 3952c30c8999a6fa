"""The robot's programs, which `humanoid up` and humanoid.launch.py start together."""

SERVERS = (
    'joint_state_service',
    'navigation_action_server',
    'battery_service',
    'arm_action_server',
    'robot_state_publisher',
)
SIMULATED = ('joint_state_service', 'navigation_action_server')
"""The programs that the program `simulation` replaces in physics."""
SIMULATION = 'simulation'
VIEWED = 'robot_state_publisher'
WORLD = 'world_server'
IN_WORLD = (WORLD, 'localiser', 'navigator')
"""The programs that run in addition if there is a world."""
BASED = ('navigation_action_server', SIMULATION)
"""The programs with parameters for the robot's start pose on the map."""
FRAMED = (*BASED, 'joint_state_service', VIEWED, *IN_WORLD)
"""The programs that publish frame names, and so need the parameter `frame_prefix`."""


def servers(*, physics: bool, world: bool = False) -> tuple[str, ...]:
    """Return the names of the programs of a robot; with `world` also those of a world."""
    more = IN_WORLD if world else ()
    if not physics:
        return (*SERVERS, *more)
    return (SIMULATION, *(name for name in SERVERS if name not in SIMULATED), *more)

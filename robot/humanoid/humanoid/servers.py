"""The robot's programs, which `humanoid up` and humanoid.launch.py start together."""

SERVERS = (
    'joint_state_service',
    'navigation_action_server',
    'battery_service',
    'arm_action_server',
    'robot_state_publisher',
)
SIMULATED = ('joint_state_service', 'navigation_action_server')
"""With physics the program `simulation` replaces these two."""
SIMULATION = 'simulation'
VIEWED = 'robot_state_publisher'
WORLD = 'world_server'
IN_WORLD = (WORLD, 'localiser', 'navigator')
"""These programs run in addition if there is a world."""
BASED = ('navigation_action_server', SIMULATION)
"""These programs are told where the robot starts on the map."""
FRAMED = (*BASED, 'joint_state_service', VIEWED, *IN_WORLD)
"""These programs publish frame names, so they need the parameter `frame_prefix`."""


def servers(*, physics: bool, world: bool = False) -> tuple[str, ...]:
    """Return the names of the programs of a robot; with `world` also those of a world."""
    more = IN_WORLD if world else ()
    if not physics:
        return (*SERVERS, *more)
    return (SIMULATION, *(name for name in SERVERS if name not in SIMULATED), *more)

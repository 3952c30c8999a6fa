"""The robot's programs that run together, as `humanoid up` and humanoid.launch.py start them."""

SERVERS = (
    'joint_state_service',
    'navigation_action_server',
    'battery_service',
    'arm_action_server',
    'robot_state_publisher',
)
SIMULATED = ('joint_state_service', 'navigation_action_server')
"""With physics one program does their work: the simulation."""
SIMULATION = 'simulation'
VIEWED = 'robot_state_publisher'
BASED = ('navigation_action_server', SIMULATION)
"""They know where the robot stands on the map."""
FRAMED = (*BASED, 'joint_state_service', VIEWED)
"""They name frames."""


def servers(*, physics: bool) -> tuple[str, ...]:
    """Return the programs that make up a robot."""
    if not physics:
        return SERVERS
    return (SIMULATION, *(name for name in SERVERS if name not in SIMULATED))

"""`humanoid up`: every server as its own process, until Ctrl-C."""

from __future__ import annotations

from humanoid.domain import claimed
from humanoid.supervisor import Ended, Printed, StopAsked, Supervisor, program

SERVERS = (
    'joint_state_service',
    'navigation_action_server',
    'battery_service',
    'arm_action_server',
    'robot_state_publisher',
)


def up() -> int:
    """Relay what the servers print. One that ends by itself leaves the others running, and 1 is returned.

    Raises Taken.
    """
    died = 0
    with claimed(may_move=False), Supervisor() as supervisor:
        for name in SERVERS:
            print(f'started {name} (pid {supervisor.start(name, program(name))})', flush=True)
        print('Ctrl-C stops them all', flush=True)
        while died < len(SERVERS):
            event = supervisor.next_event()
            if isinstance(event, Printed):
                print(f'[{event.name}] {event.line}', flush=True)
            elif isinstance(event, Ended):
                died += 1
                print(f'{event}; the others go on', flush=True)
            elif isinstance(event, StopAsked):
                print('stopping', flush=True)
                break
    return 1 if died else 0

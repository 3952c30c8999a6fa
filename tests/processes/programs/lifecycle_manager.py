"""Brings up the named nodes, in this order, takes them down in the other, and ends them: as nav2's manager.

After each change it waits for the event that tells of it. A node that fails is tried once more.
"""

from __future__ import annotations

import sys

import rclpy
from lifecycle_msgs.msg import State, Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.node import Node
from rclpy.task import Future

UP = [
    (Transition.TRANSITION_CONFIGURE, State.PRIMARY_STATE_INACTIVE),
    (Transition.TRANSITION_ACTIVATE, State.PRIMARY_STATE_ACTIVE),
]
DOWN = [
    (Transition.TRANSITION_DEACTIVATE, State.PRIMARY_STATE_INACTIVE),
    (Transition.TRANSITION_CLEANUP, State.PRIMARY_STATE_UNCONFIGURED),
    (Transition.TRANSITION_UNCONFIGURED_SHUTDOWN, State.PRIMARY_STATE_FINALIZED),
]


class Managed:
    """One node, seen from its manager."""

    def __init__(self, manager: Node, name: str) -> None:
        self.name = name
        self.manager = manager
        self.arrived: Future[str] = Future()
        self.goal = 0
        self.change_client = manager.create_client(ChangeState, f'{name}/change_state')
        self.state_client = manager.create_client(GetState, f'{name}/get_state')
        manager.create_subscription(TransitionEvent, f'{name}/transition_event', self.on_event, 10)

    def on_event(self, event: TransitionEvent) -> None:
        if event.goal_state.id == self.goal and not self.arrived.done():
            self.arrived.set_result(event.goal_state.label)

    def wait(self) -> None:
        assert self.change_client.wait_for_service(timeout_sec=20)
        assert self.state_client.wait_for_service(timeout_sec=20)

    def state(self) -> str:
        future = self.state_client.call_async(GetState.Request())
        rclpy.spin_until_future_complete(self.manager, future, timeout_sec=20)
        response = future.result()
        assert response is not None
        return response.current_state.label

    def change(self, transition: int, goal: int) -> bool:
        self.goal, self.arrived = goal, Future()
        request = ChangeState.Request(transition=Transition(id=transition))
        future = self.change_client.call_async(request)
        rclpy.spin_until_future_complete(self.manager, future, timeout_sec=20)
        response = future.result()
        assert response is not None
        if not response.success:
            print(f'{self.name} failed and is {self.state()}')
            return False
        rclpy.spin_until_future_complete(self.manager, self.arrived, timeout_sec=20)
        print(f'{self.name} became {self.arrived.result()}, and is {self.state()}')
        return True


def main() -> None:
    rclpy.init(args=[])
    manager = Node('manager')
    nodes = [Managed(manager, name) for name in sys.argv[1:]]
    for node in nodes:
        node.wait()
    for transition, goal in UP:
        for node in nodes:
            assert node.change(transition, goal) or node.change(transition, goal)
    for transition, goal in DOWN:
        for node in reversed(nodes):
            assert node.change(transition, goal)
    rclpy.shutdown()


if __name__ == '__main__':
    main()

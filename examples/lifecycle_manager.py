"""Takes a managed node once through its life. Its other half is lifecycle_talker.py.

python examples/lifecycle_manager.py NODE
"""

import sys
import time

import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.node import Node

LIFE = {
    'configure': Transition.TRANSITION_CONFIGURE,
    'activate': Transition.TRANSITION_ACTIVATE,
    'deactivate': Transition.TRANSITION_DEACTIVATE,
    'cleanup': Transition.TRANSITION_CLEANUP,
    'shutdown': Transition.TRANSITION_UNCONFIGURED_SHUTDOWN,
}


class Manager(Node):
    def __init__(self, managed):
        super().__init__('lc_manager')
        self.changing = self.create_client(ChangeState, f'{managed}/change_state')
        self.asking = self.create_client(GetState, f'{managed}/get_state')
        self.changing.wait_for_service()
        self.asking.wait_for_service()

    def ask(self, client, request):
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def change(self, name):
        answer = self.ask(self.changing, ChangeState.Request(transition=Transition(id=LIFE[name])))
        state = self.ask(self.asking, GetState.Request()).current_state.label
        print(f'{name}: {"done" if answer.success else "failed"}, {state}', flush=True)


def main():
    rclpy.init()
    if len(sys.argv) < 2:
        sys.exit('usage: lifecycle_manager.py NODE')
    try:
        manager = Manager(sys.argv[1])
        for name in LIFE:
            manager.change(name)
            time.sleep(0.3)
    except KeyboardInterrupt:
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()

"""Asks the service `add_two_ints` for one sum. Its other half is add_two_ints_server.py.

python examples/add_two_ints_client.py 2 3

Either may be started first: the client waits up to ten seconds for a server.
"""

import sys

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.node import Node
from rclpy.utilities import remove_ros_args


class AddTwoIntsClient(Node):
    def __init__(self):
        super().__init__('add_two_ints_client')
        self.client = self.create_client(AddTwoInts, 'add_two_ints')

    def ask(self, a, b):
        """Return the sum, or None if nobody answers in time."""
        if not self.client.wait_for_service(timeout_sec=10.0):
            self.get_logger().error('No server offers add_two_ints')
            return None
        future = self.client.call_async(AddTwoInts.Request(a=a, b=b))
        rclpy.spin_until_future_complete(self, future, timeout_sec=5.0)
        if not future.done():
            self.get_logger().error('The server did not answer within 5 s')
            return None
        return future.result().sum


def main():
    arguments = remove_ros_args(sys.argv)[1:]
    if len(arguments) != 2:
        sys.exit('usage: add_two_ints_client.py A B')
    a, b = map(int, arguments)
    rclpy.init()
    node = AddTwoIntsClient()
    try:
        total = node.ask(a, b)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    if total is None:
        sys.exit(1)
    print(f'{a} + {b} = {total}')


if __name__ == '__main__':
    main()

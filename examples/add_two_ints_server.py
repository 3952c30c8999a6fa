"""Offers the service `add_two_ints`. Its other half is add_two_ints_client.py.

python examples/add_two_ints_server.py
"""

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


class AddTwoIntsServer(Node):
    def __init__(self):
        super().__init__('add_two_ints_server')
        self.create_service(AddTwoInts, 'add_two_ints', self.add)
        self.get_logger().info('Ready to add')

    def add(self, request, response):
        response.sum = request.a + request.b
        self.get_logger().info(f'{request.a} + {request.b} = {response.sum}')
        return response


def main():
    rclpy.init()
    try:
        rclpy.spin(AddTwoIntsServer())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()

"""A service server. Arguments: the service's name ('add')."""

import sys

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


class AddServer(Node):
    def __init__(self, service: str) -> None:
        super().__init__(f'{service}_server')
        self.create_service(AddTwoInts, service, self.add)
        print('ready')

    def add(self, request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        response.sum = request.a + request.b
        return response


def main(service: str = 'add') -> None:
    try:
        with rclpy.init():
            rclpy.spin(AddServer(service))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    print('stopped')


if __name__ == '__main__':
    main(*sys.argv[1:])

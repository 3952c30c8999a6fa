"""The service /switch."""

import rclpy
from rclpy.executors import ExternalShutdownException
from std_srvs.srv import SetBool


def switch(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
    response.success = True
    response.message = 'it is on' if request.data else 'it is off'
    return response


try:
    with rclpy.init():
        node = rclpy.create_node('switch_server')
        node.create_service(SetBool, 'switch', switch)
        print('ready')
        rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass

"""A service whose calls are published with their contents, written for rclpy."""

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.qos import qos_profile_system_default
from rclpy.service_introspection import ServiceIntrospectionState


def add(request, response):
    response.sum = request.a + request.b
    return response


rclpy.init()
node = rclpy.create_node('introspected')
service = node.create_service(AddTwoInts, 'add', add)
service.configure_introspection(
    node.get_clock(), qos_profile_system_default, ServiceIntrospectionState.CONTENTS
)
print('ready', flush=True)
rclpy.spin(node)

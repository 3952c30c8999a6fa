# A parameter callback returns nothing.
# says: Callback returned an invalid type: check() returned None, so nothing is set; write 'return SetParametersResult(successful=True)', from rcl_interfaces.msg
import rclpy
from rclpy.parameter import Parameter


def check(parameters):  # <-- here
    print('checked')


rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed', 1.0)
node.add_on_set_parameters_callback(check)
node.set_parameters([Parameter('speed', value=2.0)])

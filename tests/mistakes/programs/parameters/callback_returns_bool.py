# A parameter callback returns True.
# says: Callback returned an invalid type: <lambda>() returned True, so nothing is set; write 'return SetParametersResult(successful=True)', from rcl_interfaces.msg
import rclpy
from rclpy.parameter import Parameter

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed', 1.0)
node.add_on_set_parameters_callback(lambda parameters: True)  # <-- here
node.set_parameters([Parameter('speed', value=2.0)])

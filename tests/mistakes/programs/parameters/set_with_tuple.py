# set_parameters() gets names and values.
# says: parameter must be instance of type '<class 'goalwire.rules.parameters.parameter.Parameter'>', got ('speed', 2.0); write Parameter('speed', value=2.0)
import rclpy

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed', 1.0)
node.set_parameters([('speed', 2.0)])  # <-- here

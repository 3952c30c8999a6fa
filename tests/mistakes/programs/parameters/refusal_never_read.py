# set_parameters() is refused, and nobody reads that.
# says: 'speed' was not set: Wrong parameter type, expected 'Type.DOUBLE' got 'Type.STRING'; speed: give a number such as 1.5, not 'fast' (double)
import rclpy
from rclpy.parameter import Parameter

rclpy.init()
node = rclpy.create_node('driver')
node.declare_parameter('speed', 1.0)
node.set_parameters([Parameter('speed', value='fast')])  # <-- here

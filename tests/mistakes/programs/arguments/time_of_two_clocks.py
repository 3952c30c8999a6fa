# Times of two clocks are subtracted.
# says: Can't subtract times with different clock types these are ROS_TIME and STEADY_TIME: take both from one clock
import rclpy
from rclpy.clock import Clock, ClockType

rclpy.init()
node = rclpy.create_node('talker')
steady = Clock(clock_type=ClockType.STEADY_TIME)
print(node.get_clock().now() - steady.now())  # <-- here

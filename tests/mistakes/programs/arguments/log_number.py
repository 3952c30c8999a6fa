# The logger gets several values, as print() does.
# says: RcutilsLogger.info() takes 2 positional arguments but 3 were given a log call takes one text: write info(f'… {value}')
import rclpy

rclpy.init()
node = rclpy.create_node('talker')
node.get_logger().info('speed', 2.0)  # <-- here

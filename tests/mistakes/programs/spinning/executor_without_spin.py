# The node is added to an executor, and the executor is never spun.
# says: node '/talker' was added to an executor that was never spun, so its callbacks never ran (1 timer): call executor.spin() after you have made it
import rclpy
from rclpy.executors import SingleThreadedExecutor

rclpy.init()
node = rclpy.create_node('talker')  # <-- here
node.create_timer(0.5, lambda: print('hello'))
executor = SingleThreadedExecutor()
executor.add_node(node)
rclpy.shutdown()

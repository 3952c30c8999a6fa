# The timer gets the result of the function and not the function.
# says: the callback of a timer must be a function: got None; give the function itself, f and not f(); the call will fail
import rclpy

rclpy.init()
node = rclpy.create_node('talker')


def talk():
    print('hello')


node.create_timer(0.1, talk())  # <-- here
rclpy.spin(node)

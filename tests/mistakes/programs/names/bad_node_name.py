# A node's name has a blank.
# says: Invalid node name: node name must not contain characters other than alphanumerics or '_': 'my robot' ^ use letters, digits and '_', and begin with a letter: write 'my_robot'
import rclpy

rclpy.init()
rclpy.create_node('my robot')  # <-- here

# A service gets the class of a message.
# says: The service type provided is not valid: String is a message, and a service is needed; a message goes into create_publisher(String, …) and create_subscription(String, …)
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('power')
node.create_service(String, 'battery', lambda request, response: response)  # <-- here

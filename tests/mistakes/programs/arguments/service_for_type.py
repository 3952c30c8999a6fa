# A publisher gets the class of a service.
# says: The message type provided is not valid: Trigger is a service, and a message is needed; a service goes into create_service(Trigger, …) and create_client(Trigger, …)
import rclpy
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node('talker')
node.create_publisher(Trigger, 'chatter', 10)  # <-- here

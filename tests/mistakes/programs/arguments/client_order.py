# The name stands before the type of a client.
# says: a class of a message, a service or an action is needed: 'battery' is a text: write the class first and then the name, as in (CLASS, 'battery', …)
import rclpy
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node('asker')
node.create_client('battery', Trigger)  # <-- here

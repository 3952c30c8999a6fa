# The name stands before the type of a service.
# says: a class of a message, a service or an action is needed: 'battery' is a text: write the class first and then the name, as in (CLASS, 'battery', …)
import rclpy
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node('power')
node.create_service('battery', Trigger, lambda request, response: response)  # <-- here

# The client waits for a name that is nearly that of the service.
# says: still waiting for service '/batery' after 5 s, no server is in domain
# within: 6 s
# ctrl-c: yes
import rclpy
from std_srvs.srv import Trigger

rclpy.init()
server = rclpy.create_node('power')
server.create_service(Trigger, 'battery', lambda request, response: response)
node = rclpy.create_node('asker')
client = node.create_client(Trigger, 'batery')
client.wait_for_service()  # <-- here

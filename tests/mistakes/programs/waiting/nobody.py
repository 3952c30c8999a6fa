# The client waits for a service that nobody offers.
# says: still waiting for service '/battery' after 5 s, no server is in domain
# within: 6 s
# ctrl-c: yes
import rclpy
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node('asker')
client = node.create_client(Trigger, 'battery')
client.wait_for_service()  # <-- here

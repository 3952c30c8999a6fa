# The server is in another domain.
# says: still waiting for service '/battery' after 5 s, no server is in domain
# within: 6 s
# ctrl-c: yes
import rclpy
from rclpy.context import Context
from std_srvs.srv import Trigger

elsewhere = Context()
elsewhere.init(domain_id=142)
server = rclpy.create_node('power', context=elsewhere)
server.create_service(Trigger, 'battery', lambda request, response: response)
rclpy.init()
node = rclpy.create_node('asker')
client = node.create_client(Trigger, 'battery')
client.wait_for_service()  # <-- here

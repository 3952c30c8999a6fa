# The client asks with another type than the service has.
# says: node '/power' serves that name with the type std_srvs/srv/Trigger, node '/asker' asks for std_srvs/srv/SetBool
# within: 6 s
# ctrl-c: yes
import rclpy
from std_srvs.srv import SetBool, Trigger

rclpy.init()
server = rclpy.create_node('power')
server.create_service(Trigger, 'battery', lambda request, response: response)
node = rclpy.create_node('asker')
client = node.create_client(SetBool, 'battery')
client.wait_for_service()  # <-- here

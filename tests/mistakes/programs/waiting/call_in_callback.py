# A callback makes a blocking call to a service of its own node.
# says: a blocking call of '/battery' can never be answered: its callback cannot run before ask() returns, and ask() waits for its answer, since both are in one mutually exclusive callback group: write 'async def ask(self):' and in it 'answer = await client.call_async(request)', or give one of them a callback group of its own, callback_group=MutuallyExclusiveCallbackGroup()
import rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger


class Asker(Node):
    def __init__(self):
        super().__init__('asker')
        self.create_service(Trigger, 'battery', lambda request, response: response)
        self.client = self.create_client(Trigger, 'battery')
        self.create_timer(0.1, self.ask)

    def ask(self):
        print(self.client.call(Trigger.Request()))  # <-- here


rclpy.init()
rclpy.spin(Asker())

# time.sleep() stands in an async callback.
# says: and other callbacks wait for it: in an 'async def' write 'await asyncio.sleep(…)' and await what takes long
# within: 5 s
# ctrl-c: yes
import time

import rclpy
from rclpy.node import Node


class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.create_timer(0.1, self.watch)
        self.create_timer(0.3, self.work)

    def watch(self):
        pass

    async def work(self):
        time.sleep(20)  # <-- here


rclpy.init()
rclpy.spin(Robot())

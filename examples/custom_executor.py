"""An executor of one's own: callbacks of urgent nodes have a thread to themselves, the others share one.

python examples/custom_executor.py
"""

import time
from concurrent.futures import ThreadPoolExecutor

import rclpy
from rclpy.executors import Executor, ExternalShutdownException, ShutdownException, TimeoutException
from rclpy.node import Node


class PriorityExecutor(Executor):
    def __init__(self):
        super().__init__()
        self.urgent_nodes = set()
        self.urgent = ThreadPoolExecutor(max_workers=1)
        self.ordinary = ThreadPoolExecutor(max_workers=1)

    def add_urgent_node(self, node):
        self.urgent_nodes.add(node)
        self.add_node(node)

    def spin_once(self, timeout_sec=None):
        try:
            handler, _, node = self.wait_for_ready_callbacks(timeout_sec=timeout_sec)
        except (TimeoutException, ShutdownException):
            return
        pool = self.urgent if node in self.urgent_nodes else self.ordinary
        pool.submit(handler)

    def shutdown(self, timeout_sec=None):
        done = super().shutdown(timeout_sec)
        for pool in (self.urgent, self.ordinary):
            pool.shutdown(cancel_futures=True)
        return done


class Mapper(Node):
    def __init__(self):
        super().__init__('mapper')
        self.create_timer(0.5, self.compute)

    def compute(self):
        self.get_logger().info('Computing for a second')
        time.sleep(1.0)


class Brake(Node):
    def __init__(self):
        super().__init__('brake')
        self.checks = 0
        self.create_timer(0.1, self.check)

    def check(self):
        self.checks += 1
        self.get_logger().info(f'Brake check {self.checks}')


def main():
    rclpy.init()
    executor = PriorityExecutor()
    try:
        executor.add_node(Mapper())
        executor.add_urgent_node(Brake())
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        executor.shutdown()
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()

"""A managed node: it talks while it is active, and somebody else decides when that is.

python examples/lifecycle_talker.py
python examples/lifecycle_manager.py lc_talker      # in another terminal
"""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from std_msgs.msg import String


class LifecycleTalker(LifecycleNode):
    def __init__(self):
        super().__init__('lc_talker')
        self.count = 0
        self.timer = None
        self.get_logger().info('Unconfigured')

    def on_configure(self, state):
        self.publisher = self.create_lifecycle_publisher(String, 'chatter', 10)
        self.timer = self.create_timer(0.1, self.talk)
        self.get_logger().info(f'Configured: I was {state.label}')
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state):
        self.get_logger().info('Activated')
        return super().on_activate(state)  # lets the publisher publish

    def on_deactivate(self, state):
        self.get_logger().info('Deactivated')
        return super().on_deactivate(state)

    def on_cleanup(self, state):
        self.release()
        self.get_logger().info(f'Cleaned up: I was {state.label}')
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state):
        self.release()
        self.get_logger().info(f'Shut down: I was {state.label}')
        return TransitionCallbackReturn.SUCCESS

    def release(self):
        if self.timer is not None:
            self.destroy_timer(self.timer)
            self.destroy_lifecycle_publisher(self.publisher)
            self.timer = None

    def talk(self):
        self.count += 1
        if self.publisher.is_activated:
            self.get_logger().info(f'Saying number {self.count}')
        self.publisher.publish(String(data=f'Number {self.count}'))  # goes nowhere unless activated


def main():
    rclpy.init()
    try:
        rclpy.spin(LifecycleTalker())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()

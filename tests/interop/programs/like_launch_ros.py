"""As launch_ros: context, node and executor in a thread of its own; containers, managed nodes, packages."""

import os
import threading
from pathlib import Path

import composition_interfaces.srv
import lifecycle_msgs.msg
import lifecycle_msgs.srv
import rclpy
import rclpy.context
import rclpy.executors
from ament_index_python.packages import get_package_prefix, get_package_share_directory
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.parameter import Parameter

LoadNode = composition_interfaces.srv.LoadNode


class Adapter:
    """launch_ros's way to have ROS beside its own loop."""

    def __init__(self):
        self.context = rclpy.context.Context()
        rclpy.init(args=[], context=self.context)
        self.node = rclpy.create_node(f'launch_ros_{os.getpid()}', context=self.context)
        self.executor = rclpy.executors.SingleThreadedExecutor(context=self.context)
        self.running = True
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        self.executor.add_node(self.node)
        while self.running:
            self.executor.spin_once(timeout_sec=1.0)
        self.executor.remove_node(self.node)

    def shutdown(self):
        self.running = False
        self.executor.wake()
        self.thread.join()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


class Managed(LifecycleNode):
    def on_configure(self, state):
        return TransitionCallbackReturn.SUCCESS


def load(request, response):
    parameters = {item.name: item.value.integer_value for item in request.parameters}
    print('loading', request.package_name, request.plugin_name, list(request.remap_rules), parameters)
    response.success, response.full_node_name, response.unique_id = True, f'/{request.node_name}', 7
    return response


def call(adapter, service, name, request):
    """Wait for the answer that the adapter's thread brings."""
    client = adapter.node.create_client(service, name)
    assert client.wait_for_service(timeout_sec=10.0)
    event = threading.Event()
    future = client.call_async(request)
    future.add_done_callback(lambda _: event.set())
    assert event.wait(10)
    assert future.exception() is None
    return future.result()


def main():
    rclpy.init()
    container = rclpy.create_node('container')
    container.create_service(LoadNode, '~/_container/load_node', load)
    managed = Managed('managed')
    others = rclpy.executors.SingleThreadedExecutor()
    others.add_node(container)
    others.add_node(managed)
    thread = threading.Thread(target=others.spin, daemon=True)
    thread.start()

    adapter = Adapter()
    request = LoadNode.Request(package_name='demo', plugin_name='demo::Talker', node_name='talker')
    request.remap_rules.append('chatter:=/talk')
    request.parameters = [Parameter('rate', value=5).to_parameter_msg()]
    answer = call(adapter, LoadNode, '/container/_container/load_node', request)
    print('loaded', answer.success, answer.full_node_name, answer.unique_id)

    configured = threading.Event()

    def on_transition(message):
        if message.goal_state.label == 'inactive':
            configured.set()

    adapter.node.create_subscription(
        lifecycle_msgs.msg.TransitionEvent, '/managed/transition_event', on_transition, 10
    )
    change = lifecycle_msgs.srv.ChangeState.Request()
    change.transition.id = lifecycle_msgs.msg.Transition.TRANSITION_CONFIGURE
    print('changed', call(adapter, lifecycle_msgs.srv.ChangeState, '/managed/change_state', change).success)
    print('told', configured.wait(10))

    share = Path(get_package_share_directory('composition_interfaces'))
    prefix = get_package_prefix('composition_interfaces')
    same = share.samefile(Path(prefix, 'share', 'composition_interfaces'))
    print('share', same)
    adapter.shutdown()
    others.shutdown()
    thread.join()
    rclpy.shutdown()


main()

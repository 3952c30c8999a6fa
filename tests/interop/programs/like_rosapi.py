"""As rosapi and rosbridge: types told apart and described, the graph, parameters of other nodes."""

import inspect
import re
import threading
from pathlib import Path

import rclpy
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.executors import SingleThreadedExecutor
from rosidl_adapter.parser import parse_message_string
from rosidl_runtime_py import get_interface_path
from rosidl_runtime_py.utilities import get_message
from std_srvs.srv import Trigger


def full_text(root):
    """The definition of a type and of all that is in it."""
    text, seen, waiting = '', set(), [root]
    while waiting:
        package, _, name = waiting.pop().rpartition('/')
        package = package.split('/')[0]
        definition = Path(get_interface_path(f'{package}/msg/{name}')).read_text(encoding='utf-8')
        text += definition
        for field in parse_message_string(package, name, definition).fields:
            inner = f'{field.type.pkg_name}/{field.type.type}'
            if field.type.pkg_name is not None and inner not in seen:
                seen.add(inner)
                waiting.append(inner)
    return text, sorted(seen)


def typedef(name):
    """Field names, types and lengths, and the constants, as rosapi reads them from an instance."""
    instance = get_message(name)()
    fields = []
    for slot in instance.__slots__:
        key = slot[1:]
        if key in instance._fields_and_field_types:
            kind = instance._fields_and_field_types[key]
            fields.append((key, *(re.findall('sequence<([^<]+)>', kind) or [kind])))
    constants = [
        key
        for key, value in inspect.getmembers(instance)
        if key not in instance.__slots__ and not key.startswith('_') and not inspect.isroutine(value)
    ]
    return fields, [key for key in constants if key.isupper()]


def ask(node, service, name, request):
    client = node.create_client(service, name)
    assert client.wait_for_service(10.0)
    future = client.call_async(request)
    event = threading.Event()
    future.add_done_callback(lambda _: event.set())
    assert event.wait(10)
    node.destroy_client(client)
    return future.result()


def main():
    rclpy.init()
    robot, api = rclpy.create_node('robot'), rclpy.create_node('rosapi')
    robot.declare_parameter('speed', 3)
    robot.create_service(Trigger, 'ready', lambda request, response: response)
    executor = SingleThreadedExecutor()
    executor.add_node(robot)
    executor.add_node(api)
    thread = threading.Thread(target=executor.spin, daemon=True)
    thread.start()

    text, inside = full_text('geometry_msgs/msg/TwistStamped')
    print(inside, 'float64 x' in text)
    print(typedef('diagnostic_msgs/msg/DiagnosticStatus'))
    print(
        ask(
            api, ListParameters, '/robot/list_parameters', ListParameters.Request(prefixes=['speed'])
        ).result.names
    )
    values = ask(api, GetParameters, '/robot/get_parameters', GetParameters.Request(names=['speed'])).values
    print(values[0].type, values[0].integer_value)
    print([types for name, types in api.get_service_names_and_types() if name == '/ready'])
    print(sorted(f'{space}{name}' for name, space in api.get_node_names_and_namespaces()))
    executor.shutdown()
    thread.join()
    rclpy.shutdown()


main()

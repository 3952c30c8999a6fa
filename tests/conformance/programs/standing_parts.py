"""The standing publishers and services that every node has, and the type description service."""

import rclpy
from rcl_interfaces.msg import LoggerLevel, ParameterEvent
from rcl_interfaces.srv import GetLoggerLevels, GetParameters, ListParameters, SetLoggerLevels
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from std_msgs.msg import String
from type_description_interfaces.srv import GetTypeDescription

initialized = rclpy.init(args=[])


def services(node):
    return sorted(service.service_name for service in node.services)


def made(**options):
    node = Node('fresh', **options)
    found = (
        sorted(publisher.topic_name for publisher in node.publishers),
        services(node),
        len(list(node.subscriptions)),
        len(list(node.clients)),
        len(list(node.timers)),
    )
    node.destroy_node()
    return found


made()
made(enable_rosout=False)
made(start_parameter_services=False)
made(enable_logger_service=True)
made(parameter_overrides=[Parameter('start_type_description_service', value=False)])
n = Node('n', enable_logger_service=True)
n.declare_parameter('a', 1).value
n.declare_parameter('b', 'x').value
w = Node('w')
executor = SingleThreadedExecutor()
executor.add_node(n)
executor.add_node(w)


def call(kind, name, request):
    """Call a service of the node."""
    client = w.create_client(kind, f'/n/{name}')
    client.wait_for_service(10)
    future = client.call_async(request)
    executor.spin_until_future_complete(future, 10)
    w.destroy_client(client)
    return future.result()


# -- parameter services

call(GetParameters, 'get_parameters', GetParameters.Request(names=['a', 'b']))
call(ListParameters, 'list_parameters', ListParameters.Request(prefixes=['a']))
c = AsyncParameterClient(w, '/n')
c.wait_for_services(10)
c.services_are_ready()


def x(future):
    executor.spin_until_future_complete(future, 10)
    return future.result()


x(c.list_parameters())
x(c.list_parameters(['b'], 1))
x(c.get_parameters(['a', 'nope']))
x(c.get_parameters(['nope']))
x(c.get_parameters([]))
x(c.get_parameter_types(['a', 'b']))
x(c.get_parameter_types(['a', 'nope']))
x(c.describe_parameters(['a']))
x(c.describe_parameters(['a', 'nope']))
x(c.set_parameters([Parameter('a', value=9)]))
x(c.set_parameters([Parameter('a', value='s')]))
x(c.set_parameters([Parameter('a', value=10), Parameter('b', value='y')]))
x(c.set_parameters_atomically([Parameter('a', value=11)]))
x(c.delete_parameters(['a']))
x(c.set_parameters([Parameter('a', value=12).to_parameter_msg()]))
x(c.load_parameter_file('/nonexistent'))
n.get_parameter('a').value
AsyncParameterClient(w, '/none').services_are_ready()
AsyncParameterClient(w, '/none').wait_for_services(0.05)
[response.successful for response in x(c.set_parameters([Parameter('nope', value=1)])).results]

# -- parameter events

events = []
s = w.create_subscription(ParameterEvent, '/parameter_events', events.append, 10)


def settle(count):
    for _ in range(100):
        if len(events) >= count:
            break
        executor.spin_once(timeout_sec=0.05)
    told = [
        (
            event.node,
            event.stamp.sec > 0,
            [(p.name, p.value.type) for p in event.new_parameters],
            [(p.name, p.value.type) for p in event.changed_parameters],
            [(p.name, p.value.type) for p in event.deleted_parameters],
        )
        for event in events
    ]
    events.clear()
    return told


for _ in range(200):
    if s.get_publisher_count() >= 2:
        break
    executor.spin_once(timeout_sec=0.05)
n.declare_parameter('late', 1).value
settle(1)
n.set_parameters([Parameter('late', value=2)])
settle(1)
n.set_parameters([Parameter('a', value=3), Parameter('b', value='z')])
settle(2)
n.set_parameters_atomically([Parameter('a', value=5), Parameter('b', value='q')])
settle(1)
n.set_parameters([Parameter('a', value='bad')])
n.undeclare_parameter('late')
n.declare_parameter('typ', Parameter.Type.INTEGER).type_
settle(1)
n.set_parameters([Parameter('typ', value=1)])
settle(1)

# -- logger levels

request = GetLoggerLevels.Request(names=['n', 'unheard.of'])
[(level.name, level.level) for level in call(GetLoggerLevels, 'get_logger_levels', request).levels]
levels = [LoggerLevel(name='n', level=10), LoggerLevel(name='n', level=77)]
call(SetLoggerLevels, 'set_logger_levels', SetLoggerLevels.Request(levels=levels)).results
[(level.name, level.level) for level in call(GetLoggerLevels, 'get_logger_levels', request).levels]
n.get_logger().get_effective_level()

# -- type descriptions

hash_of_string = 'RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18'
p = n.create_publisher(String, 'chat', 1)
request = GetTypeDescription.Request(type_name='std_msgs/msg/String', type_hash=hash_of_string)
response = call(GetTypeDescription, 'get_type_description', request)
(response.successful, response.failure_reason)
response.type_description
[(source.type_name, source.encoding) for source in response.type_sources]
unknown = GetTypeDescription.Request(type_name='no_msgs/msg/Nope', type_hash=hash_of_string)
response = call(GetTypeDescription, 'get_type_description', unknown)
(response.successful, bool(response.failure_reason))
n.destroy_node()
w.destroy_node()
rclpy.shutdown()

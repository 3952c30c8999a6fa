"""Service events, and what a node tells of its types."""

import time

import rclpy
from geometry_msgs.msg import PoseStamped, Quaternion
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_system_default
from rclpy.service_introspection import ServiceIntrospectionState
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden
from rclpy.type_description_service import START_TYPE_DESCRIPTION_SERVICE_PARAM
from std_srvs.srv import SetBool
from type_description_interfaces.srv import GetTypeDescription

initialized = rclpy.init(args=[])
n = Node('n', namespace='ns')
listener = Node('listener')
executor = rclpy.get_global_executor()
executor.add_node(n)
executor.add_node(listener)
EVENTS = '/ns/switch/_service_event'

# -- service events

ServiceIntrospectionState.OFF
[str(state) for state in (ServiceIntrospectionState.METADATA, ServiceIntrospectionState.CONTENTS)]
SetBool.Event()
seen = []
subscription = listener.create_subscription(SetBool.Event, EVENTS, seen.append, 100)


def switch(request, response):
    response.success = request.data
    response.message = 'switched'
    return response


def spin_until(wanted, seconds=10):
    end = time.monotonic() + seconds
    while not wanted() and time.monotonic() < end:
        executor.spin_once(timeout_sec=0.05)
    return wanted()


def call(client, request):
    client.wait_for_service(10)
    future = client.call_async(request)
    spin_until(future.done)
    return future.result()


def introspect(state, publishers):
    for end in (service, client):
        end.configure_introspection(n.get_clock(), qos_profile_system_default, state)
    return spin_until(lambda: listener.count_publishers(EVENTS) == publishers)


def steps(count):
    spin_until(lambda: len(seen) >= count)
    told = sorted((e.info.event_type, e.info.sequence_number, [*e.request], [*e.response]) for e in seen)
    seen.clear()
    return told


service = n.create_service(SetBool, 'switch', switch)
client = n.create_client(SetBool, 'switch')
topic_or_service_is_hidden(EVENTS)
introspect(ServiceIntrospectionState.METADATA, 2)
spin_until(lambda: False, 0.5)
call(client, SetBool.Request(data=True))
steps(4)
introspect(ServiceIntrospectionState.CONTENTS, 2)
call(client, SetBool.Request(data=False))
steps(4)
sorted(name for name, types in n.get_topic_names_and_types() if 'event' in name)
[info.topic_type for info in n.get_publishers_info_by_topic(EVENTS)]
sorted(publisher.topic_name for publisher in n.publishers)
introspect(ServiceIntrospectionState.OFF, 0)
call(client, SetBool.Request(data=True))
steps(0)
service.configure_introspection(n.get_clock(), qos_profile_system_default, 1)
client.configure_introspection(n.get_clock(), qos_profile_system_default, 'CONTENTS')
client.destroy()
client.configure_introspection(n.get_clock(), qos_profile_system_default, ServiceIntrospectionState.OFF)

# -- type descriptions

START_TYPE_DESCRIPTION_SERVICE_PARAM
[name for name in (service.service_name for service in n.services) if 'type' in name]
n.get_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM).value
n.describe_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM)
n.set_parameters([Parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM, value=False)])
off = Node('off', parameter_overrides=[Parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM, value=False)])
[name for name in (service.service_name for service in off.services) if 'type' in name]
Node('bad', parameter_overrides=[Parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM, value=1)])
describe = listener.create_client(GetTypeDescription, '/ns/n/get_type_description')


def described(type_hash, **fields):
    """Ask for a description; tell of it without the texts of the definitions."""
    answer = call(describe, GetTypeDescription.Request(type_hash=str(type_hash), **fields))
    answer.type_sources = [
        type(source)(type_name=source.type_name, encoding=source.encoding) for source in answer.type_sources
    ]
    return answer


pose, turn = (n.create_publisher(cls, cls.__name__, 1) for cls in (PoseStamped, Quaternion))
hashes = {
    name: n.get_publishers_info_by_topic(name)[0].topic_type_hash
    for name in ('PoseStamped', 'Quaternion', '/rosout', '/parameter_events')
}
described(hashes['PoseStamped'])
described(hashes['Quaternion'], include_type_sources=False)
described(hashes['Quaternion'], type_name='another/msg/Name').type_description.type_description.type_name
described(hashes['/rosout']).type_sources
described(hashes['/parameter_events']).type_sources
n.destroy_publisher(turn)
described(hashes['Quaternion'])
described('')
described('RIHS01_12')
described('RIHS01_' + 64 * '0')
rclpy.shutdown()

"""Service introspection: what each side publishes of a call."""

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_system_default
from rclpy.service_introspection import ServiceIntrospectionState
from service_msgs.msg import ServiceEventInfo
from std_srvs.srv import SetBool

initialized = rclpy.init(args=[])
n = Node('n')
OFF, METADATA, CONTENTS = (
    ServiceIntrospectionState.OFF,
    ServiceIntrospectionState.METADATA,
    ServiceIntrospectionState.CONTENTS,
)
names = {
    ServiceEventInfo.REQUEST_SENT: 'request sent',
    ServiceEventInfo.REQUEST_RECEIVED: 'request received',
    ServiceEventInfo.RESPONSE_SENT: 'response sent',
    ServiceEventInfo.RESPONSE_RECEIVED: 'response received',
}
[(state.name, int(state)) for state in (OFF, METADATA, CONTENTS)]


def answer(request, response):
    response.message = 'answered'
    return response


v = n.create_service(SetBool, 'set', answer)
c = n.create_client(SetBool, 'set')
heard = []
s = n.create_subscription(SetBool.Event, 'set/_service_event', heard.append, 10)
executor = SingleThreadedExecutor()
executor.add_node(n)
c.wait_for_service(10)


def call(count):
    """Call once; return the events of it."""
    heard.clear()
    future = c.call_async(SetBool.Request(data=True))
    executor.spin_until_future_complete(future, 10)
    for _ in range(200 if count else 2):
        if len(heard) >= count > 0:
            break
        executor.spin_once(timeout_sec=0.05)
    told = [
        (names[e.info.event_type], list(e.request), list(e.response), e.info.sequence_number) for e in heard
    ]
    return sorted(told, key=str)


def configure(service, client):
    """Set both sides, and wait until the subscription knows of them."""
    v.configure_introspection(n.get_clock(), qos_profile_system_default, service)
    c.configure_introspection(n.get_clock(), qos_profile_system_default, client)
    wanted = (service != OFF) + (client != OFF)
    for _ in range(200):
        if s.get_publisher_count() == wanted:
            return True
        executor.spin_once(timeout_sec=0.05)
    return False


call(0)
configure(METADATA, OFF)
[(what, request, response) for what, request, response, _ in call(2)]
configure(METADATA, METADATA)
[(what, request, response) for what, request, response, _ in call(4)]
configure(CONTENTS, CONTENTS)
[(what, request, response) for what, request, response, _ in call(4)]
len({e.info.sequence_number for e in heard})
all(e.info.stamp.sec > 0 for e in heard)
configure(OFF, OFF)
call(0)
v.configure_introspection(n.get_clock(), qos_profile_system_default, 5)
n.destroy_node()
rclpy.shutdown()

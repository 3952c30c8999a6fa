"""The graph: nodes, topics, services, endpoints, counts, waiting."""

import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

initialized = rclpy.init(args=['program', '--ros-args', '-e', '/enclave'])
quiet = {'start_parameter_services': False, 'enable_rosout': False}
a = Node('ga', namespace='/gn', **quiet)
b = Node('gb', **quiet)
p = a.create_publisher(String, 'chat', QoSProfile(depth=3, reliability=ReliabilityPolicy.BEST_EFFORT))
s = b.create_subscription(String, '/gn/chat', print, 3)
hidden = a.create_publisher(String, '_hidden', 1)
second = b.create_publisher(String, '/gn/chat', 1)
v = a.create_service(SetBool, 'set', print)
c = b.create_client(SetBool, '/gn/set')
a.wait_for_node('/gb', 10)
b.wait_for_node('/gn/ga', 10)
a.wait_for_node('/nonode', 0.01)
a.wait_for_node('gb', 0.5)
c.wait_for_service(10)


def settle(seen, wanted, turns=200):
    """Wait until the graph shows what is wanted."""
    for _ in range(turns):
        if seen() == wanted:
            return
        rclpy.spin_once(a, timeout_sec=0.05)


def own(found):
    """Without what every node has."""
    return sorted(entry for entry in found if entry[0].startswith('/gn') and 'type_desc' not in entry[0])


settle(lambda: a.count_publishers('chat'), 2)
settle(lambda: a.count_clients('set'), 1)
sorted(a.get_node_names())
sorted(a.get_node_names_and_namespaces())
sorted(a.get_node_names_and_namespaces_with_enclaves())
sorted(a.get_fully_qualified_node_names())
own(a.get_topic_names_and_types())
own(b.get_service_names_and_types())
own(a.get_publisher_names_and_types_by_node('ga', '/gn'))
own(a.get_publisher_names_and_types_by_node('gb', '/'))
own(a.get_subscriber_names_and_types_by_node('gb', '/'))
own(a.get_service_names_and_types_by_node('ga', '/gn'))
own(a.get_client_names_and_types_by_node('gb', '/'))
own(a.get_client_names_and_types_by_node('ga', '/gn'))
a.get_publisher_names_and_types_by_node('nonode', '/')
a.get_publisher_names_and_types_by_node('bad name', '/')
a.get_publisher_names_and_types_by_node('ga', 'bad')
a.get_service_names_and_types_by_node('nonode', '/')
(a.count_publishers('chat'), a.count_publishers('/gn/chat'), a.count_subscribers('chat'))
(a.count_services('set'), a.count_clients('set'), b.count_services('/gn/set'), b.count_services('set'))
a.count_publishers('a b')
a.count_services('')
a.count_publishers('{bad}')
infos = sorted(a.get_publishers_info_by_topic('chat'), key=lambda info: info.node_name)
[(info.node_name, info.node_namespace, info.topic_type, info.endpoint_type) for info in infos]
[(info.qos_profile.reliability, info.qos_profile.durability) for info in infos]
[str(info.topic_type_hash) for info in infos]
[len(info.endpoint_gid) for info in infos][0] in {16, 24}
infos[0] == infos[0]
infos[0] == infos[1]
hash(infos[0])
[info.endpoint_type for info in a.get_subscriptions_info_by_topic('chat')]
a.get_publishers_info_by_topic('/nosuch')
a.get_publishers_info_by_topic('a b')
infos[0].topic_type_hash.version
(type(infos[0].topic_type_hash.value), len(infos[0].topic_type_hash.value))
s.get_publisher_count()
p.get_subscription_count()
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
b.create_publisher(String, 'latched', latched).topic_name
settle(lambda: a.count_publishers('/latched'), 1)
[info.qos_profile.durability for info in a.get_publishers_info_by_topic('/latched')]
b.destroy_publisher(second)
settle(lambda: a.count_publishers('chat'), 1)
own(a.get_topic_names_and_types())
a.destroy_service(v)
settle(lambda: a.count_services('set'), 0)
c.service_is_ready()
b.destroy_node()
settle(lambda: len(a.get_node_names()), 1)
a.get_node_names()
a.count_subscribers('chat')
t = a.create_client(Trigger, 'x')
t.wait_for_service(0.01)
a.destroy_node()
rclpy.shutdown()

"""Publishers, subscriptions, services, clients, timers: arguments, what each tells of itself, its end."""

import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import String
from std_srvs.srv import SetBool

rclpy.init(args=[])

# -- nodes

Node('')
Node('a b')
Node('a/b')
Node('1a')
Node('/a')
Node('~a')
Node('é')
Node('a' * 256)
Node(None)
Node(5)
Node('ok', namespace='bad ns')
Node('ok', namespace='/a//b')
Node('ok', namespace='a/')
Node('ok', namespace='/1a')
Node('ok', namespace='~/x')
Node('ok', namespace='/' + 'x' * 250)
Node('ok', cli_args=['--ros-args', '-r', 'bad'])
Node('ok', cli_args=['--ros-args', 'bad'])
Node('ok', cli_args=['plain']).get_name()
Node('ok', namespace=None).get_namespace()
Node('ok', namespace='').get_namespace()
Node('ok', namespace='/').get_namespace()
Node('ok', namespace='foo').get_namespace()
Node('ok', namespace='/foo/bar').get_fully_qualified_name()
Node('ok').get_fully_qualified_name()
Node('_h').get_name()
Node('ok').get_logger().name
Node('ok', namespace='/a/b').get_logger().name
Node('ok', context='x')

n = Node('nn', namespace='/ns')

# -- names of topics and services

n.create_publisher(String, 'a b', 1)
n.create_publisher(String, '', 1)
n.create_publisher(String, 'a//b', 1)
n.create_publisher(String, 'a/', 1)
n.create_publisher(String, '~a', 1)
n.create_publisher(String, '{what}', 1)
n.create_publisher(String, None, 1)
n.create_publisher(String, 5, 1)
n.create_publisher(String, 'x' * 300, 1)
n.create_subscription(String, '1a', print, 1)
n.create_service(SetBool, 'a b', print)
n.create_client(SetBool, 'a-b')
n.create_client(SetBool, None)
n.create_publisher(String, 'topic', 1).topic_name
n.create_publisher(String, '~/topic', 1).topic_name
n.create_publisher(String, '~', 1).topic_name
n.create_publisher(String, '/topic', 1).topic_name
n.create_publisher(String, 'topic', 1).topic
n.create_publisher(String, '{node}/{ns}/topic', 1).topic_name
n.create_subscription(String, '{node}/topic', print, 1).topic_name
n.create_subscription(String, 'topic', print, 1).topic
n.create_service(SetBool, '~/srv', print).service_name
n.create_service(SetBool, 'srv', print).srv_name
n.create_client(SetBool, 'srv').service_name
n.create_client(SetBool, 'srv').srv_name
n.resolve_topic_name('a')
n.resolve_topic_name('~/a')
n.resolve_topic_name('/a')
n.resolve_topic_name('a b')
n.resolve_topic_name('')
n.resolve_topic_name(None)
n.resolve_service_name('a')
n.resolve_service_name('a b')

# -- types, profiles and callbacks

n.create_publisher(SetBool, 'a', 1)
n.create_publisher(SetBool.Request, 'request', 1).topic_name
n.create_publisher(int, 'a', 1)
n.create_publisher(None, 'a', 1)
n.create_publisher('String', 'a', 1)
n.create_publisher(String, 'a', None)
n.create_publisher(String, 'a', 'x')
n.create_publisher(String, 'a', -1)
n.create_publisher(String, 'a', 1.5)
n.create_publisher(String, 'a', 0)
n.create_publisher(String, 'a', True)
n.create_publisher(String, 'a')
n.create_publisher(String, 'a', QoSProfile(depth=3)).qos_profile.depth
n.create_subscription(String, 'a', None, 1)
n.create_subscription(String, 'a', 5, 1)
n.create_subscription(String, 'a', lambda: None, 1)
n.create_subscription(String, 'a', lambda message: None, 1)
n.create_subscription(String, 'a', lambda message, info: None, 1)
n.create_subscription(String, 'a', lambda a, b, c: None, 1)
n.create_subscription(String, 'a', lambda a, b=1, c=2: None, 1)
n.create_subscription(String, 'a', lambda *a: None, 1)
n.create_subscription(String, 'a', print, 1)
n.create_subscription(String, 'a', [].append, 1)
n.create_subscription(SetBool, 'a', print, 1)
n.create_service(String, 'a', print)
n.create_service(SetBool, 'a', None)
n.create_service(SetBool, 'a', print, qos_profile=5)
n.create_client(String, 'a')
n.create_client(SetBool.Request, 'a')

# -- timers, guard conditions, rates

n.create_timer('x', print)
n.create_timer(-1, print)
n.create_timer(None, print)
n.create_timer(0, print).timer_period_ns
n.create_timer(0.5, print).timer_period_ns
n.create_timer(1e-9, print).timer_period_ns
n.create_timer(1e12, print)
n.create_timer(0.1, None)
n.create_timer(0.1, 5)
n.create_guard_condition(print)
n.create_guard_condition(None)
n.create_rate(0)
n.create_rate(-1)
n.create_rate('x')

# -- callback groups

n.default_callback_group.__class__.__name__
group = ReentrantCallbackGroup()
s = n.create_subscription(String, 'grouped', print, 1, callback_group=group)
s.callback_group is group
group.has_entity(s)
n.create_subscription(String, 'grouped', print, 1).callback_group is n.default_callback_group
n.create_subscription(String, 'grouped', print, 1, callback_group=5)
n.create_timer(1, print, 5)
MutuallyExclusiveCallbackGroup() == MutuallyExclusiveCallbackGroup()

# -- publishing, and the end of each

p = n.create_publisher(String, 'pp', 1)
p.publish(1)
p.publish(None)
p.publish(String)
p.publish(SetBool.Request())
p.publish(b'\x00\x01\x00\x00\x02\x00\x00\x00a\x00')
p.publish(String(data=1))
p.get_subscription_count()
p.wait_for_all_acked()
p.assert_liveliness()
p.msg_type
p.handle.__class__.__name__
n.destroy_publisher(p)
n.destroy_publisher(p)
p.publish(String())
p.get_subscription_count()
p.topic_name
p.destroy()
n.destroy_publisher(None)
n.destroy_timer('x')
s = n.create_subscription(String, 'pp', print, 1)
s.get_publisher_count()
s.msg_type
s.raw
n.destroy_subscription(s)
n.destroy_subscription(s)
s.topic_name
c = n.create_client(SetBool, 'cc')
c.service_is_ready()
c.wait_for_service(0)
c.wait_for_service(0.01)
c.srv_type
n.destroy_client(c)
n.destroy_client(c)
c.service_is_ready()
c.service_name
v = n.create_service(SetBool, 'vv', print)
v.srv_type
n.destroy_service(v)
n.destroy_service(v)
v.service_name
t = n.create_timer(1, print)
n.destroy_timer(t)
n.destroy_timer(t)
t.is_ready()
g = n.create_guard_condition(print)
n.destroy_guard_condition(g)
n.destroy_guard_condition(g)
g.trigger()

# -- what a node tells of itself

type(n.publishers).__name__
type(n.waitables).__name__
len(list(Node('fresh').clients))
len(list(Node('fresh').timers))
len(list(Node('fresh').guards))
n.get_logger().__class__.__name__
n.get_clock().clock_type
n.executor
with Node('w') as w:
    print(w.get_name())
n.destroy_node()
n.get_name()
n.create_publisher(String, 'a', 1)
n.create_subscription(String, 'a', print, 1)
n.create_client(SetBool, 'a')
n.create_service(SetBool, 'a', print)
n.create_timer(1, print)
n.resolve_topic_name('a')
n.get_logger().name
n.count_publishers('a')
rclpy.shutdown()

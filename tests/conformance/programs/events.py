"""QoS events and overriding options: which are told, what they hold, which are refused."""

import rclpy
import rclpy.event_handler
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks, UnsupportedEventTypeError
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions
from std_msgs.msg import String

initialized = rclpy.init(args=[])
n = Node('n')
seen = []


def settle(count):
    for _ in range(200):
        if len(seen) >= count:
            break
        rclpy.spin_once(n, timeout_sec=0.05)
    told, seen[:] = sorted(seen, key=str), []
    return told


def noting(what):
    return lambda event: seen.append((what, *numbers(event)))


def numbers(event):
    names = ('total_count', 'total_count_change', 'current_count', 'current_count_change', 'last_policy_kind')
    found = [(name, getattr(event, name)) for name in names if hasattr(event, name)]
    return [(name, getattr(value, 'name', value)) for name, value in found]


# -- incompatible policies

quick = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
publisher_events = PublisherEventCallbacks(incompatible_qos=noting('publisher'))
subscription_events = SubscriptionEventCallbacks(incompatible_qos=noting('subscription'))
p = n.create_publisher(String, 'a', quick, event_callbacks=publisher_events)
s = n.create_subscription(String, 'a', print, 1, event_callbacks=subscription_events)
settle(2)
len(p.event_handlers) > 0
p.get_subscription_count()
n.destroy_publisher(p)
n.destroy_subscription(s)

# -- matched

publisher_events = PublisherEventCallbacks(matched=noting('publisher'))
subscription_events = SubscriptionEventCallbacks(matched=noting('subscription'))
p = n.create_publisher(String, 'b', 1, event_callbacks=publisher_events)
s = n.create_subscription(String, 'b', print, 1, event_callbacks=subscription_events)
settle(2)
n.destroy_subscription(s)
settle(1)
s = n.create_subscription(String, 'b', print, 1, event_callbacks=subscription_events)
settle(2)
n.destroy_publisher(p)
settle(1)
n.destroy_subscription(s)

# -- callbacks

[name for name in vars(PublisherEventCallbacks()) if not name.startswith('_')]
[name for name in vars(SubscriptionEventCallbacks()) if not name.startswith('_')]
PublisherEventCallbacks(nonsense=print)
issubclass(UnsupportedEventTypeError, Exception)


def failing(event):
    seen.append('called')
    raise ValueError('boom')


p = n.create_publisher(String, 'c', 1, event_callbacks=PublisherEventCallbacks(matched=failing))
s = n.create_subscription(String, 'c', print, 1)
settle(1)
n.destroy_publisher(p)
n.destroy_subscription(s)

# -- overriding options

o = Node(
    'o',
    parameter_overrides=[
        Parameter('qos_overrides./chatter.publisher.depth', value=7),
        Parameter('qos_overrides./chatter.publisher.reliability', value='best_effort'),
        Parameter('qos_overrides./chatter.subscription_mine.depth', value=8),
        Parameter('qos_overrides./wrong.publisher.reliability', value='nonsense'),
        Parameter('qos_overrides./typed.publisher.depth', value='x'),
    ],
)
options = QoSOverridingOptions.with_default_policies()
[str(kind) for kind in options.policy_kinds]
options.entity_id
options.callback
p = o.create_publisher(String, 'chatter', 10, qos_overriding_options=options)
(p.qos_profile.depth, p.qos_profile.reliability)
mine = QoSOverridingOptions.with_default_policies(entity_id='mine')
s = o.create_subscription(String, 'chatter', print, 10, qos_overriding_options=mine)
s.qos_profile.depth
[name for name in o.list_parameters([], 0).names if name.startswith('qos_')]
o.describe_parameter('qos_overrides./chatter.publisher.depth').read_only
o.describe_parameter('qos_overrides./chatter.publisher.depth').type
o.set_parameters([Parameter('qos_overrides./chatter.publisher.depth', value=9)])
p = o.create_publisher(String, 'plain', 5, qos_overriding_options=options)
o.get_parameter('qos_overrides./plain.publisher.depth').value
o.get_parameter('qos_overrides./plain.publisher.history').value
o.create_publisher(String, 'wrong', 10, qos_overriding_options=options)
o.create_publisher(String, 'typed', 10, qos_overriding_options=options)
all_kinds = QoSOverridingOptions(list(QoSPolicyKind)[1:2])
[str(kind) for kind in all_kinds.policy_kinds]
refusing = QoSOverridingOptions([QoSPolicyKind.DEPTH], callback=lambda profile: False)
o.create_publisher(String, 'refused', 10, qos_overriding_options=refusing)
issubclass(InvalidQosOverridesError, Exception)
timed = QoSOverridingOptions([QoSPolicyKind.DEADLINE, QoSPolicyKind.DURABILITY, QoSPolicyKind.LIVELINESS])
p = o.create_publisher(String, 'timed', 10, qos_overriding_options=timed)
[name for name in o.list_parameters([], 0).names if '/timed' in name]
o.get_parameter('qos_overrides./timed.publisher.deadline').value
o.get_parameter('qos_overrides./timed.publisher.durability').value
QoSProfile(depth=1, deadline=Duration(seconds=1)).deadline
o.destroy_node()
n.destroy_node()
rclpy.shutdown()

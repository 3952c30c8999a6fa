"""Publishing and subscribing in one process: what arrives, in which order, and with which information."""

import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import Int32, String, UInt8MultiArray

initialized = rclpy.init(args=[])
n = Node('n')
got = []


def spin(count, turns=200):
    """Spin until `count` messages came, or nothing comes any more."""
    for _ in range(turns):
        if len(got) >= count:
            break
        rclpy.spin_once(n, timeout_sec=0.05)


def matched(publisher, count=1):
    """Wait until a publisher has that many subscriptions."""
    for _ in range(200):
        if publisher.get_subscription_count() >= count:
            return True
        rclpy.spin_once(n, timeout_sec=0.05)
    return False


def taken():
    values, got[:] = list(got), []
    return values


p = n.create_publisher(String, 'chat', 10)
s = n.create_subscription(String, 'chat', lambda message: got.append(message.data), 10)
matched(p)
p.get_subscription_count()
s.get_publisher_count()
p.publish(String(data='a'))
spin(1)
taken()
[p.publish(String(data=str(number))) for number in range(5)]
spin(5)
taken()
p.publish(String(data='é\n"'))
p.publish(String(data=''))
spin(2)
taken()
p.publish(serialize_message(String(data='serialized')))
spin(1)
taken()

# -- bytes, and information about the message

raw = n.create_subscription(String, 'chat', got.append, 10, raw=True)
raw.raw
matched(p, 2)
p.publish(String(data='ab'))
spin(2)
sorted(taken(), key=str)
n.destroy_subscription(raw)
n.destroy_subscription(s)
informed = n.create_subscription(String, 'chat', lambda message, info: got.append((message, info)), 10)
matched(p)
p.publish(String(data='x'))
spin(1)
message, info = taken()[0]
message
type(info)
sorted(info)
[type(info[key]) for key in ('source_timestamp', 'received_timestamp')]
0 < info['source_timestamp'] <= info['received_timestamp']
n.destroy_subscription(informed)
both = n.create_subscription(String, 'chat', lambda data, info: got.append((data, type(info))), 10, raw=True)
matched(p)
p.publish(String(data='x'))
spin(1)
taken()
n.destroy_subscription(both)

# -- callbacks

s = n.create_subscription(String, 'chat', lambda message: got.append(message.data), 10)
s.callback = lambda message: got.append(message.data.upper())
matched(p)
p.publish(String(data='upper'))
spin(1)
taken()
s.callback = None
s.callback = lambda a, b, c: None


async def coroutine(message):
    got.append(f'async {message.data}')


s.callback = coroutine
p.publish(String(data='x'))
spin(1)
taken()


def broken(message):
    got.append(message.data)
    raise ValueError('boom')


s.callback = broken
p.publish(String(data='x'))
spin(1)
taken()
s.callback = lambda message: got.append(message.data)
p.publish(String(data='goes on'))
spin(1)
taken()
n.destroy_subscription(s)

# -- depth and durability

s = n.create_subscription(Int32, 'numbers', lambda message: got.append(message.data), 2)
p = n.create_publisher(Int32, 'numbers', 10)
matched(p)
[p.publish(Int32(data=number)) for number in range(5)]
p.wait_for_all_acked()
spin(2)
taken()
latched = QoSProfile(depth=2, durability=DurabilityPolicy.TRANSIENT_LOCAL)
p = n.create_publisher(Int32, 'latched', latched)
[p.publish(Int32(data=number)) for number in range(5)]
late = n.create_subscription(Int32, 'latched', lambda message: got.append(message.data), latched)
spin(2)
taken()
volatile = n.create_subscription(Int32, 'latched', lambda message: got.append(message.data), 10)
matched(p, 2)
p.publish(Int32(data=7))
spin(2)
taken()
n.destroy_subscription(late)
n.destroy_subscription(volatile)
shallow = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
p = n.create_publisher(Int32, 'shallow', shallow)
[p.publish(Int32(data=number)) for number in range(5)]
wait_for_message(Int32, n, 'shallow', qos_profile=shallow, time_to_wait=5)
best_effort = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
p = n.create_publisher(Int32, 'quick', best_effort)
s = n.create_subscription(Int32, 'quick', lambda message: got.append(message.data), best_effort)
matched(p)
p.publish(Int32(data=1))
spin(1)
taken()

# -- big messages, arrays, two subscriptions, two types

p = n.create_publisher(UInt8MultiArray, 'big', 10)
s = n.create_subscription(UInt8MultiArray, 'big', lambda m: got.append((len(m.data), sum(m.data))), 10)
matched(p)
p.publish(UInt8MultiArray(data=bytes(range(256)) * 4096))
spin(1)
taken()
p = n.create_publisher(PoseWithCovarianceStamped, 'pose', 10)
s = n.create_subscription(PoseWithCovarianceStamped, 'pose', got.append, 10)
matched(p)
sent = PoseWithCovarianceStamped()
sent.header.frame_id = 'map'
sent.pose.covariance[35] = 2.5
p.publish(sent)
spin(1)
received = taken()[0]
received == sent
received is sent
received.pose.covariance[35]
type(received.pose.covariance)
p = n.create_publisher(Int32, 'twice', 10)
first = n.create_subscription(Int32, 'twice', lambda message: got.append(('first', message.data)), 10)
second = n.create_subscription(Int32, 'twice', lambda message: got.append(('second', message.data)), 10)
matched(p, 2)
p.publish(Int32(data=1))
spin(2)
sorted(taken())

# -- waiting for one message

wait_for_message(Int32, n, 'none', time_to_wait=0.05)
wait_for_message(Int32, n, 'none', time_to_wait=0)
latest = n.create_publisher(Int32, 'latest', latched)
latest.publish(Int32(data=9))
wait_for_message(Int32, n, 'latest', qos_profile=latched, time_to_wait=5)
wait_for_message(5, n, 'latest', time_to_wait=0.05)
len([s for s in n.subscriptions if s.topic_name == '/latest'])
n.destroy_node()
p.publish(Int32(data=1))
rclpy.shutdown()

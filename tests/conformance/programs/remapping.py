"""Remapping: what `--ros-args -r` makes of nodes, topics and services."""

from rclpy.context import Context
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import SetBool


def names(*args, node='nn', **options):
    """Return the names of a node, two topics and a service under these arguments."""
    context = Context()
    context.init(list(args))
    node = Node(node, context=context, enable_rosout=False, start_parameter_services=False, **options)
    found = (
        node.get_fully_qualified_name(),
        node.create_publisher(String, 'topic', 1).topic_name,
        node.create_subscription(String, '~/topic', print, 1).topic_name,
        node.create_service(SetBool, 'srv', print).service_name,
        node.create_client(SetBool, '~/srv').service_name,
        node.get_logger().name,
    )
    node.destroy_node()
    context.shutdown()
    return found


def ros(*args, **options):
    return names('program', '--ros-args', *args, **options)


ros()
ros('-r', '__ns:=/x')
ros('-r', '__ns:=/')
ros('-r', '__ns:=/x', namespace='/y')
ros('-r', '__node:=z')
ros('-r', '__name:=z')
ros('-r', '__node:=z', '-r', '__ns:=/a/b')
ros('-r', '__node:=a', '-r', '__name:=b')
ros('-r', 'nn:__node:=z', '-r', 'zz:__ns:=/q')
ros('-r', '__node:=zz', '-r', 'nn:__ns:=/w', '-r', 'zz:__ns:=/q')
ros('-r', 'topic:=/t2')
ros('-r', 'topic:=t2')
ros('-r', 'topic:=~/t2')
ros('-r', '/topic:=/abs')
ros('-r', '~/topic:=rel')
ros('-r', '/nn/topic:=rel')
ros('-r', 'topic:=/t2', namespace='/ns')
ros('-r', '/topic:=/t2', namespace='/ns')
ros('-r', '/ns/topic:=t2', namespace='/ns')
ros('-r', 'topic:=t2', '-r', '__ns:=/q')
ros('-r', '/q/topic:=t2', '-r', '__ns:=/q')
ros('-r', 'nn:topic:=only')
ros('-r', 'zz:topic:=only')
ros('-r', '__node:=zz', '-r', 'nn:topic:=a', '-r', 'zz:topic:=b')
ros('-r', 'srv:=s2')
ros('-r', 'rosservice://srv:=s2', '-r', 'rostopic://topic:=t3')
ros('-r', 'rosservice://topic:=s2', '-r', 'rostopic://srv:=t3')
ros('-r', 'rosservice:///srv:=s2')
ros('-r', 'nn:rostopic://topic:=t3')
ros('-r', 'topic:=a', '-r', 'topic:=b')
ros('-r', 'topic:=srv', '-r', 'srv:=c')
ros('--remap', 'topic:=a')
ros('-r', 'topic:=a', '--', '-r', 'topic:=b')
ros('-r', 'topic:=a', '--ros-args', '-r', 'srv:=b')
names('-r', 'topic:=a')
names('topic:=a')
names('__ns:=/q')
names('program', '--', '--ros-args', '-r', 'topic:=a')
ros('-r', '__node:=g', use_global_arguments=False)
names(cli_args=['--ros-args', '-r', 'topic:=own'])
names(cli_args=['-r', 'x'])
names(cli_args=['--ros-args', '-r', '__node:=own', '-r', '__ns:=/own'])
ros('-r', 'topic:=process', cli_args=['--ros-args', '-r', 'topic:=own'])
ros('-r', 'srv:=process', cli_args=['--ros-args', '-r', 'topic:=own'])
ros('-r', '__ns:=/process', cli_args=['--ros-args', '-r', '__node:=own'])
ros('-r', 'srv:=process', use_global_arguments=False, cli_args=['--ros-args', '-r', 'topic:=own'])
ros('-r', 'topic:={node}')
ros('-r', '{node}:=x')
ros('-r', '~:=x')
ros('-r', 'topic:=~')
ros('-r', 'topic:=1a')
ros('-r', 'topic:=a//b')
ros('-r', 'topic:=x:=y')
ros('-r', '/nn:topic:=x')
ros('-r', '__ns:=/a//b')
ros('-r', '__ns:=/a/')
ros('-r', '__node:=z/y')
ros('-r', '__node:=1')
ros('-r', '__foo:=1')
ros('-r', 'a__b:=c')

context = Context()
context.init(['program', '--ros-args', '-r', 'a:=/b', '-r', 'rosservice://c:=/d'])
node = Node('nn', namespace='/ns', context=context)
node.resolve_topic_name('a')
node.resolve_topic_name('a', only_expand=True)
node.resolve_topic_name('c')
node.resolve_service_name('a')
node.resolve_service_name('c')
node.resolve_service_name('c', only_expand=True)
node.destroy_node()
context.shutdown()

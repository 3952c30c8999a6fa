"""Init and shutdown: the default context, contexts of one's own, what each refuses."""

import os

import rclpy
import rclpy.utilities
from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node

# -- before init

rclpy.ok()
Node('a')
rclpy.create_node('a')
rclpy.spin(None)
rclpy.shutdown()
rclpy.try_shutdown()
rclpy.utilities.try_shutdown()
rclpy.utilities.get_default_context()
rclpy.utilities.get_default_context().ok()
rclpy.utilities.get_default_context().get_domain_id()
rclpy.utilities.get_default_context() is rclpy.utilities.get_default_context()
SingleThreadedExecutor()

# -- while it is open

rclpy.init()
rclpy.ok()
rclpy.init()
rclpy.utilities.get_default_context().get_domain_id() == int(__import__('os').environ['ROS_DOMAIN_ID'])
rclpy.get_global_executor().__class__
rclpy.get_global_executor() is rclpy.get_global_executor()
n = Node('a')
first = rclpy.utilities.get_default_context()
n.context is first
seen = []
first.on_shutdown(lambda: seen.append('default'))

# -- after shutdown

rclpy.shutdown()
seen
rclpy.ok()
first.ok()
rclpy.shutdown()
rclpy.utilities.get_default_context() is first
rclpy.try_shutdown()
n.get_name()
n.get_fully_qualified_name()
n.get_namespace()
n.get_topic_names_and_types()
n.destroy_node()
n.destroy_node()
n.get_name()
n.get_namespace()
Node('late')

# -- again

rclpy.init(args=[])
rclpy.ok()
rclpy.shutdown()
rclpy.init(args=None, domain_id=7)
rclpy.utilities.get_default_context().get_domain_id()
rclpy.try_shutdown()
rclpy.ok()

# -- arguments that are refused

rclpy.init(args=['--ros-args', '-r', 'foo:='])
rclpy.ok()
rclpy.init(args=['x', '--ros-args', '-p', 'a:=1', '--ros-args', 'bad'])
rclpy.init(args=['--ros-args', '--log-level', 'nope'])
rclpy.init(args=['--ros-args', '--log-level'])
rclpy.init(args=['--ros-args', '-p', 'novalue'])
rclpy.init(args=['--ros-args', '-p', 'a:='])
rclpy.init(args=['--ros-args', '-p', 'a:={b: 1}'])
rclpy.init(args=['--ros-args', '-r', '__ns:=x'])
rclpy.init(args=['--ros-args', '-r', '__node:=a b'])
rclpy.init(args=['--ros-args', '-r', 'topic:=bad name'])
rclpy.init(args=['--ros-args', '-r', '/*/topic:=x'])
rclpy.init(args=['--ros-args', '-r', r'topic:=\1'])
rclpy.init(args=['--ros-args', '-r'])
rclpy.init(args=['--ros-args', '-e', 'x'])
rclpy.init(args=['--ros-args', '-e'])
rclpy.init(args=['--ros-args', '--params-file'])
rclpy.init(args=['--ros-args', '--log-config-file'])
rclpy.init(args=['--ros-args', '--log-file-name'])
rclpy.init(args=['--ros-args', '-x', 'y', '--enable-nothing'])
rclpy.init(args=[1])
rclpy.init(args=[None])
rclpy.init(args='abc')
rclpy.init(domain_id=-1)
rclpy.init(domain_id='x')
rclpy.init([])
rclpy.ok()

# -- contexts of one's own

c = Context()
c.ok()
c.get_domain_id()
c.shutdown()
c.try_shutdown()
c.init([])
c.init([])
c.ok()
(rclpy.ok(), rclpy.ok(context=c))
c.on_shutdown(lambda: print('on_shutdown'))
c.on_shutdown('x')
n = Node('own', context=c)
n.context is c
Node('default')
rclpy.init(context=c)
c.shutdown()
c.ok()
c.shutdown()
c.try_shutdown()
c.on_shutdown(lambda: print('late'))
c.init()
n.destroy_node()
d = Context()
rclpy.init(args=[], context=d, domain_id=3)
d.get_domain_id()
rclpy.ok()
rclpy.shutdown(context=d)
d.ok()
d = Context()
d.init([], domain_id=4)
d.on_shutdown(lambda: 1 / 0)
d.shutdown()
d.ok()
with Context() as e:
    print(e.ok())
e.ok()
two = [Context(), Context()]
[context.init([], domain_id=number) for number, context in enumerate(two)]
nodes = [Node('n', context=context) for context in two]
[context.get_domain_id() for context in two]
two[0].shutdown()
[context.ok() for context in two]
nodes[1].get_name()
two[1].shutdown()
rclpy.spin_once(nodes[1], timeout_sec=0)
rclpy.spin(nodes[1])
MultiThreadedExecutor(context=two[0])

# -- what is not for ROS

rclpy.utilities.remove_ros_args(['p', 'a', '--ros-args', '-r', 'x:=y', '--', 'b'])
rclpy.utilities.remove_ros_args(['p', '--ros-args', '-p', 'a:=1', '--log-level', 'info'])
rclpy.utilities.remove_ros_args(['p', '--ros-args', '--ros-args', '--', '--', 'z'])
rclpy.utilities.remove_ros_args(['p', '--', '--ros-args', '-r', 'a:=b'])
rclpy.utilities.remove_ros_args(['a', '-r', 'x:=y'])
rclpy.utilities.remove_ros_args(['a', '--ros-args', 'bad'])
rclpy.utilities.remove_ros_args(['a', '--ros-args', '-r', 'bad'])
rclpy.utilities.remove_ros_args(('a', '--ros-args'))
rclpy.utilities.remove_ros_args([])
rclpy.utilities.remove_ros_args(['a', 1])
len(rclpy.utilities.remove_ros_args())
rclpy.utilities.timeout_sec_to_nsec(None)
rclpy.utilities.timeout_sec_to_nsec(-1)
rclpy.utilities.timeout_sec_to_nsec(1.5)
rclpy.utilities.timeout_sec_to_nsec('x')
isinstance(rclpy.utilities.get_rmw_implementation_identifier(), str)
rclpy.utilities.get_rmw_implementation_identifier() == __import__('os').environ['RMW_IMPLEMENTATION']

# -- the domain in the environment

os.environ['ROS_DOMAIN_ID'] = 'abc'
Context().init([])
os.environ['ROS_DOMAIN_ID'] = '-1'
Context().init([])
os.environ['ROS_DOMAIN_ID'] = ''
Context().init([])
Context().init({'a': 1})
Context().init(iter(['a']))
Context().init(5)

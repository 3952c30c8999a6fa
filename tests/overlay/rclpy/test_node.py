"""Nodes: names, remapping, what they make and how it ends."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import pytest
from example_interfaces.srv import AddTwoInts
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode
from helpers.standing import own
from rclpy.action import ActionServer
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.exceptions import (
    InvalidHandle,
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
)
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import AsyncNode
from rclpy.impl.base_node import BaseNode
from rclpy.lifecycle import LifecycleNode
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.waitable import Waitable
from std_msgs.msg import String

from goalwire.errors import RCLError, RCLInvalidROSArgsError

PUBLIC = """
PARAM_REL_TOL add_on_set_parameters_callback add_post_set_parameters_callback
add_pre_set_parameters_callback add_waitable clients context count_clients count_publishers count_services
count_subscribers create_client create_guard_condition create_publisher create_rate create_service
create_subscription create_timer declare_parameter declare_parameters default_callback_group
describe_parameter describe_parameters destroy_client destroy_guard_condition destroy_node destroy_publisher
destroy_rate destroy_service destroy_subscription destroy_timer executor get_client_names_and_types_by_node
get_clock get_fully_qualified_name get_fully_qualified_node_names get_logger get_name get_namespace
get_node_names get_node_names_and_namespaces get_node_names_and_namespaces_with_enclaves get_parameter
get_parameter_or get_parameter_type get_parameter_types get_parameters get_parameters_by_prefix
get_publisher_names_and_types_by_node get_publishers_info_by_topic get_service_names_and_types
get_service_names_and_types_by_node get_subscriber_names_and_types_by_node get_subscriptions_info_by_topic
get_topic_names_and_types guards handle has_parameter list_parameters publishers
remove_on_set_parameters_callback remove_post_set_parameters_callback remove_pre_set_parameters_callback
remove_waitable resolve_service_name resolve_topic_name services set_descriptor set_parameters
set_parameters_atomically subscriptions timers undeclare_parameter wait_for_node waitables
"""
"""The public names of rclpy's Node."""


def nothing(*_: object) -> Any: ...


@pytest.fixture
def node(make_node: MakeNode) -> Node:
    return make_node('nn', namespace='ns')


# -- names -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('name', 'reason', 'index'),
    [
        ('', 'node name must not be empty', 0),
        ('a b', "must not contain characters other than alphanumerics or '_'", 1),
        ('a/b', "must not contain characters other than alphanumerics or '_'", 1),
        ('/a', "must not contain characters other than alphanumerics or '_'", 0),
        ('é', "must not contain characters other than alphanumerics or '_'", 0),
        ('1a', 'node name must not start with a number', 0),
        ('a' * 256, "node name length should not exceed '255'", 254),
    ],
)
def test_a_bad_node_name_is_shown_with_its_character(
    context: Context, name: str, reason: str, index: int
) -> None:
    with pytest.raises(InvalidNodeNameException) as caught:
        Node(name, context=context)
    first, second, third = str(caught.value).splitlines()
    assert first.startswith('Invalid node name: ')
    assert reason in first
    assert second == f"  '{name}'"
    assert third == f'   {" " * index}^'


def test_what_is_no_name_is_refused(context: Context) -> None:
    with pytest.raises(RCLError, match='name argument is null'):
        Node(None, context=context)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match='5'):
        Node(5, context=context)  # type: ignore[arg-type]


@pytest.mark.parametrize('namespace', ['bad ns', '/a//b', 'a/', '/1a', '~/x'])
def test_a_bad_namespace_is_refused(context: Context, namespace: str) -> None:
    with pytest.raises(InvalidNamespaceException, match=r'^Invalid namespace: '):
        Node('ok', context=context, namespace=namespace)


@pytest.mark.parametrize(
    ('namespace', 'expected', 'full', 'logger'),
    [
        (None, '/', '/n1', 'n1'),
        ('', '/', '/n1', 'n1'),
        ('/', '/', '/n1', 'n1'),
        ('foo', '/foo', '/foo/n1', 'foo.n1'),
        ('/foo/bar', '/foo/bar', '/foo/bar/n1', 'foo.bar.n1'),
    ],
)
def test_names_of_a_node(
    make_node: MakeNode, namespace: str | None, expected: str, full: str, logger: str
) -> None:
    node = make_node('n1', namespace=namespace)
    assert node.get_name() == 'n1'
    assert node.get_namespace() == expected
    assert node.get_fully_qualified_name() == full
    assert node.get_logger().name == logger
    assert repr(node).startswith('<rclpy.node.Node object at')


def test_names_of_entities(node: Node) -> None:
    assert node.create_publisher(String, 'topic', 1).topic_name == '/ns/topic'
    assert node.create_publisher(String, '~/topic', 1).topic_name == '/ns/nn/topic'
    assert node.create_publisher(String, '/topic', 1).topic_name == '/topic'
    assert node.create_publisher(String, 'topic', 1).topic == 'topic'
    assert node.create_subscription(String, '{node}/topic', nothing, 1).topic_name == '/ns/nn/topic'
    service = node.create_service(AddTwoInts, '~/srv', nothing)
    assert (service.service_name, service.srv_name) == ('/ns/nn/srv', '~/srv')
    client = node.create_client(AddTwoInts, 'srv')
    assert (client.service_name, client.srv_name) == ('/ns/srv', 'srv')


def test_resolving_names(node: Node) -> None:
    assert node.resolve_topic_name('a') == '/ns/a'
    assert node.resolve_topic_name('~/a') == '/ns/nn/a'
    assert node.resolve_service_name('a') == '/ns/a'
    for wrong in ('a b', ''):
        with pytest.raises(RCLError, match=r'^failed to resolve name: '):
            node.resolve_topic_name(wrong)
        with pytest.raises(RCLError, match=r'^failed to resolve name: '):
            node.resolve_service_name(wrong)


@pytest.mark.parametrize('name', ['a b', '', 'a//b', '1a', 'a/', '/', 'a~'])
def test_a_bad_topic_name_is_refused(node: Node, name: str) -> None:
    with pytest.raises(InvalidTopicNameException, match=r'^Invalid topic name: '):
        node.create_publisher(String, name, 1)
    with pytest.raises(InvalidTopicNameException, match=r'^Invalid topic name: '):
        node.create_subscription(String, name, nothing, 1)
    assert [publisher.topic_name for publisher in node.publishers] == ['/parameter_events']
    assert list(node.subscriptions) == []


def test_an_unknown_substitution_is_a_value_error(node: Node) -> None:
    text = r'^topic name .\{bad\}. is invalid: unknown substitution: \{bad\}$'
    with pytest.raises(ValueError, match=text):
        node.create_publisher(String, '{bad}', 1)
    with pytest.raises(ValueError, match=text):
        node.create_client(AddTwoInts, '{bad}')
    with pytest.raises(RCLError, match=r'^failed to resolve name: unknown substitution: \{bad\}$'):
        node.resolve_topic_name('{bad}')


def test_after_shutdown_nothing_is_made_any_more(node: Node, context: Context) -> None:
    context.shutdown()
    for make in (
        lambda: node.create_publisher(String, 'a', 1),
        lambda: node.create_subscription(String, 'a', nothing, 1),
        lambda: node.create_client(AddTwoInts, 'a'),
        lambda: node.create_service(AddTwoInts, 'a', nothing),
        lambda: node.create_timer(1, nothing),
        lambda: node.create_guard_condition(nothing),
    ):
        with pytest.raises(RCLError, match=r"^node '/.*': the context was shut down"):
            make()
    assert not node.wait_for_node('/elsewhere', 10)


@pytest.mark.parametrize('name', ['a b', 'a-b', '', '1a'])
def test_a_bad_service_name_is_refused(node: Node, name: str) -> None:
    with pytest.raises(InvalidServiceNameException, match=r'^Invalid service name: '):
        node.create_service(AddTwoInts, name, nothing)
    with pytest.raises(InvalidServiceNameException, match=r'^Invalid service name: '):
        node.create_client(AddTwoInts, name)
    standing = f'{node.get_fully_qualified_name()}/'
    assert all(service.service_name.startswith(standing) for service in node.services)
    assert list(node.clients) == []


# -- arguments -------------------------------------------------------------------------------------------


@pytest.mark.parametrize('qos', [None, 'x', 1.5], ids=repr)
def test_what_is_no_profile_is_refused(node: Node, qos: Any) -> None:
    with pytest.raises(TypeError, match=r'^Expected QoSProfile or int, but received '):
        node.create_publisher(String, 'a', qos)
    with pytest.raises(TypeError, match=r'^Expected QoSProfile or int, but received '):
        node.create_subscription(String, 'a', nothing, qos)


def test_a_depth_is_a_profile(node: Node) -> None:
    assert node.create_publisher(String, 'a', 7).qos_profile == QoSProfile(depth=7)
    with pytest.warns(UserWarning, match='zero depth'):
        assert node.create_publisher(String, 'a', 0).qos_profile.depth == 0
    with pytest.raises(ValueError, match='history depth must be greater than or equal to zero'):
        node.create_publisher(String, 'a', -1)


def test_a_type_of_another_kind_is_refused(node: Node) -> None:
    with pytest.raises(
        RuntimeError, match=r'^The message type provided is not valid: .* and a message is needed'
    ):
        node.create_publisher(AddTwoInts, 'a', 1)
    with pytest.raises(
        RuntimeError, match=r'^The service type provided is not valid: .* and a service is needed'
    ):
        node.create_service(String, 'a', nothing)  # type: ignore[arg-type]
    with pytest.raises(RuntimeError, match=r'^The service type provided is not valid'):
        node.create_client(String, 'a')  # type: ignore[arg-type]
    with pytest.raises(AttributeError, match=r'^a class of a message, a service or an action is needed: '):
        node.create_publisher(int, 'a', 1)


@pytest.mark.parametrize(
    'callback', [None, 5, lambda: None, lambda a, b, c: None, lambda *, a: None], ids=lambda _: ''
)
def test_a_subscription_wants_one_or_two_arguments(node: Node, callback: Any) -> None:
    with pytest.raises(
        RuntimeError, match='the callback of a subscription is a function that is callable with one argument'
    ):
        node.create_subscription(String, 'a', callback, 1)


class _Listener:
    def one(self, message: String) -> None: ...

    def two(self, message: String, info: object) -> None: ...

    def __call__(self, message: String) -> None: ...


@pytest.mark.parametrize(
    ('callback', 'wants_info'),
    [
        (lambda message: None, False),
        (lambda message, info: None, True),
        (lambda message, more=1: None, False),
        (lambda *args: None, False),
        (_Listener().one, False),
        (_Listener().two, True),
        (_Listener(), False),
        (print, False),
        ([].append, False),
    ],
)
def test_a_subscription_tells_one_argument_from_two(
    node: Node, callback: Callable[..., object], wants_info: bool
) -> None:
    assert node.create_subscription(String, 'a', callback, 1)._wants_info is wants_info


def test_timers_take_a_period(node: Node) -> None:
    assert node.create_timer(0, nothing).timer_period_ns == 0
    with pytest.raises(ValueError, match="could not convert string to float: 'x'"):
        node.create_timer('x', nothing)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match='NoneType'):
        node.create_timer(None, nothing)  # type: ignore[arg-type]
    with pytest.raises(RCLError, match=r'^failed to create timer: timer period must be non-negative\n'):
        node.create_timer(-1, nothing)


def test_a_rate_wants_a_frequency(node: Node) -> None:
    with pytest.raises(ValueError, match='frequency must be > 0'):
        node.create_rate(0)
    rate = node.create_rate(10)
    assert node.destroy_rate(rate) is True
    assert node.destroy_rate(rate) is False
    assert list(node.timers) == []


# -- remapping -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('arguments', 'names'),
    [
        (['-r', '__ns:=/x'], ('/x/nn', '/x/topic', '/x/nn/topic', '/x/srv')),
        (['-r', 'topic:=/t2'], ('/nn', '/t2', '/nn/topic', '/srv')),
        (['-r', '~/topic:=rel'], ('/nn', '/topic', '/rel', '/srv')),
        (['-r', 'nn:topic:=only'], ('/nn', '/only', '/nn/topic', '/srv')),
        (['-r', 'zz:topic:=only'], ('/nn', '/topic', '/nn/topic', '/srv')),
        (['-r', 'nn:__node:=z', '-r', 'zz:__ns:=/q'], ('/z', '/topic', '/z/topic', '/srv')),
        (['-r', '/topic:=/abs'], ('/nn', '/abs', '/nn/topic', '/srv')),
        (['-r', 'rosservice://srv:=s2', '-r', 'rostopic://topic:=t3'], ('/nn', '/t3', '/nn/topic', '/s2')),
        (['-r', 'srv:=s2'], ('/nn', '/topic', '/nn/topic', '/s2')),
        (['-r', 'topic:=a', '-r', 'topic:=b'], ('/nn', '/a', '/nn/topic', '/srv')),
        (['-r', 'topic:=a', '--', '-r', 'topic:=b'], ('/nn', '/a', '/nn/topic', '/srv')),
    ],
    ids=' '.join,
)
@pytest.mark.parametrize('of_the_process', [True, False], ids=['process', 'node'])
def test_names_are_remapped(
    isolated: dict[str, str], arguments: list[str], names: tuple[str, ...], of_the_process: bool
) -> None:
    context = Context()
    arguments = ['--ros-args', *arguments]
    context.init(args=arguments if of_the_process else [])
    try:
        node = Node('nn', context=context, cli_args=None if of_the_process else arguments)
        assert (
            node.get_fully_qualified_name(),
            node.create_publisher(String, 'topic', 1).topic_name,
            node.create_subscription(String, '~/topic', nothing, 1).topic_name,
            node.create_service(AddTwoInts, 'srv', nothing).service_name,
        ) == names
        assert (
            node.resolve_topic_name('topic', only_expand=True) == node.get_namespace().rstrip('/') + '/topic'
        )
    finally:
        context.shutdown()


def test_a_node_may_ignore_the_process_s_arguments(isolated: dict[str, str]) -> None:
    context = Context()
    context.init(args=['--ros-args', '-r', '__node:=g', '-p', 'a:=1'])
    try:
        node = Node('nn', context=context, use_global_arguments=False)
        assert node.get_name() == 'nn'
        assert node.declare_parameter('a', 0).value == 0
    finally:
        context.shutdown()


def test_bad_arguments_of_a_node_are_refused(context: Context) -> None:
    with pytest.raises(RCLInvalidROSArgsError, match=r"^Failed to parse ROS arguments: .*'-r bad'"):
        Node('nn', context=context, cli_args=['--ros-args', '-r', 'bad'])


# -- what it owns, and the end ---------------------------------------------------------------------------


def test_a_node_lists_what_it_made(node: Node) -> None:
    made = [
        (node.create_publisher(String, 'a', 1), 'publishers', node.destroy_publisher),
        (node.create_subscription(String, 'a', nothing, 1), 'subscriptions', node.destroy_subscription),
        (node.create_client(AddTwoInts, 'a'), 'clients', node.destroy_client),
        (node.create_service(AddTwoInts, 'a', nothing), 'services', node.destroy_service),
        (node.create_timer(1, nothing), 'timers', node.destroy_timer),
        (node.create_guard_condition(nothing), 'guards', node.destroy_guard_condition),
    ]
    for entity, listed, destroy in made:
        assert entity in getattr(node, listed)
        assert destroy(entity) is True  # type: ignore[operator]
        assert destroy(entity) is False  # type: ignore[operator]
        assert destroy(None) is False  # type: ignore[operator]
        assert destroy('x') is False  # type: ignore[operator]
        assert entity not in getattr(node, listed)
    assert type(node.default_callback_group) is MutuallyExclusiveCallbackGroup


def test_the_block_of_a_node_ends_with_its_destruction(make_node: MakeNode) -> None:
    with make_node('brief') as node:
        publisher = node.create_publisher(String, 'a', 1)
        assert publisher.logger_name == node.get_logger().name == 'brief'
    for destroyed in (lambda: node.create_timer(1, print), lambda: publisher.logger_name):
        with pytest.raises(InvalidHandle):
            destroyed()


def test_a_destroyed_node_takes_everything_along(make_node: MakeNode, context: Context) -> None:
    from example_interfaces.action import Fibonacci

    node, other = make_node('goes'), make_node('stays')
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    publisher = node.create_publisher(String, 'a', 1)
    subscription = node.create_subscription(String, 'a', nothing, 1)
    client = node.create_client(AddTwoInts, 'a')
    service = node.create_service(AddTwoInts, 'a', nothing)
    server = ActionServer(node, Fibonacci, 'fib', lambda _: Fibonacci.Result())
    timer = node.create_timer(0.001, lambda: pytest.fail('still runs'))
    node.destroy_node()
    node.destroy_node()
    assert list(node.timers) == []
    assert executor.get_nodes() == []
    assert node.executor is None
    executor.spin_once(timeout_sec=0.01)
    executor.shutdown()
    for use in (
        node.get_name,
        node.get_namespace,
        node.get_fully_qualified_name,
        node.get_node_names,
        lambda: node.count_publishers('a'),
        lambda: node.resolve_topic_name('a'),
        lambda: node.create_publisher(String, 'a', 1),
        lambda: node.create_subscription(String, 'a', nothing, 1),
        lambda: node.create_client(AddTwoInts, 'a'),
        lambda: node.create_service(AddTwoInts, 'a', nothing),
        lambda: node.create_timer(1, nothing),
        lambda: publisher.publish(String()),
        subscription.get_publisher_count,
        timer.is_canceled,
        lambda: client.call_async(AddTwoInts.Request()),
        lambda: service.service_name,
    ):
        with pytest.raises(InvalidHandle):
            use()
    assert server.destroyed
    for listed in (node.publishers, node.subscriptions, node.clients, node.services, node.waitables):
        assert list(listed) == []
    from helpers.spinning import wait_until

    wait_until(context, lambda: other.get_node_names() == ['stays'])
    assert own(other.get_topic_names_and_types()) == []
    assert own(other.get_service_names_and_types()) == []


def test_a_node_goes_whole_where_an_entity_fails_to(make_node: MakeNode) -> None:
    class Stubborn(Publisher[String]):
        def destroy(self) -> None:
            super().destroy()
            raise ValueError('stubborn')

    other, node = make_node('other'), make_node('fails')
    early = node.create_service(AddTwoInts, 'add', nothing)
    node.create_publisher(String, 'a', 1, publisher_class=Stubborn)
    with pytest.raises(ValueError, match='stubborn'):
        node.destroy_node()
    assert early.destroyed
    assert other.get_node_names() == ['other']


def test_a_node_moves_between_executors(node: Node, context: Context) -> None:
    with SingleThreadedExecutor(context=context) as one, SingleThreadedExecutor(context=context) as two:
        assert one.add_node(node) is True
        assert one.add_node(node) is False
        assert node.executor is one
        node.executor = two
        assert (one.get_nodes(), two.get_nodes()) == ([], [node])
        node.executor = None
        assert two.get_nodes() == []


def test_waitables_are_listed(node: Node) -> None:
    waitable: Waitable[None] = Waitable(ReentrantCallbackGroup())
    node.add_waitable(waitable)
    assert list(node.waitables) == [waitable]
    node.remove_waitable(waitable)
    with pytest.raises(ValueError, match='not in list'):
        node.remove_waitable(waitable)


def test_what_is_no_callback_group_is_refused_and_leaves_nothing_behind(node: Node) -> None:
    group: Any = 5
    for create in (
        lambda: node.create_timer(1, print, group),
        lambda: node.create_guard_condition(print, group),
        lambda: node.create_publisher(String, 'a', 1, callback_group=group),
        lambda: node.create_subscription(String, 'a', print, 1, callback_group=group),
        lambda: node.create_client(AddTwoInts, 'a', callback_group=group),
        lambda: node.create_service(AddTwoInts, 'a', nothing, callback_group=group),
    ):
        with pytest.raises(
            AttributeError, match="'int' object has no attribute 'add_entity': callback_group"
        ):
            create()
    assert [list(node.timers), list(node.guards), list(node.subscriptions)] == [[], [], []]
    assert node.count_publishers('a') == 0


def test_a_node_that_cannot_be_made_is_not_in_the_graph(make_node: MakeNode, context: Context) -> None:
    other, profile = make_node('other'), cast('Any', 'no profile')
    with pytest.raises(TypeError, match='Expected QoSProfile or int'):
        Node('never', context=context, rosout_qos_profile=profile)
    assert other.get_node_names() == ['other']


@pytest.mark.parametrize('node_class', [Node, LifecycleNode, AsyncNode])
def test_a_program_s_own_names_do_not_meet_those_of_its_node(
    context: Context, node_class: type[BaseNode]
) -> None:
    """Programs' subclasses of Node add names of their own, so ours are rclpy's or begin with _ros_."""
    rclpy_s_own = {
        '_clients', '_clock', '_context', '_default_callback_group', '_guards', '_logger', '_parameters',
        '_publishers', '_services', '_subscriptions', '_time_source', '_timers', '_type_description_service',
        '_state_machine', '_pre_set_parameters_callbacks', '_on_set_parameters_callbacks',
        '_post_set_parameters_callbacks',
    }  # fmt: skip
    node = node_class('any', context=context, enable_logger_service=True)
    names = {name for name in dir(node) if not name.startswith(('__', '_ros_'))}
    assert {name for name in names if name.startswith('_')} <= rclpy_s_own
    if node_class is Node:
        assert {name for name in names if not name.startswith('_')} == set(PUBLIC.split())
    node.handle.destroy()


def test_a_program_may_use_the_names_it_likes(context: Context) -> None:
    class Arm(Node):
        def __init__(self) -> None:
            self.work_queue, self.core, self._count, self._group, self._graph = 'h', 'c', 'n', 'g', 'w'
            super().__init__('arm', context=context)
            self.create_timer(0.001, self._offer)
            self.offers = 0

        def _offer(self) -> None:
            self.offers += 1

        def _set(self) -> None: ...

    arm = Arm()
    assert arm.count_publishers('nobody') == 0
    arm.declare_parameter('speed', 1)
    assert arm.set_parameters([Parameter('speed', value=2)])[0].successful
    with SingleThreadedExecutor(context=context) as executor:
        executor.add_node(arm)
        executor.spin_once(timeout_sec=PATIENCE)
    assert arm.offers == 1
    assert (arm.work_queue, arm.core, arm._count, arm._group, arm._graph) == ('h', 'c', 'n', 'g', 'w')
    arm.destroy_node()

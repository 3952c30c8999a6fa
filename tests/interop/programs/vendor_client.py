"""Uses all that `vendor_server.py` serves, under whichever rclpy and RMW runs it; counts what was right."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sized
from functools import partial
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String
from std_srvs.srv import SetBool

try:
    from test_msgs.action import Fibonacci  # type: ignore[import-not-found]  # of the real rclpy
except ImportError:
    from example_interfaces.action import Fibonacci

CALLS, GOALS, LARGEST = map(int, sys.argv[1:4])
"""How many calls and goals, and how many bytes of the largest message."""
PATIENCE_S = 20.0
SILENCE_S = 1.0
"""How long topics with other QoS must be silent."""
SIZES = (1, 1000, 100_000, 1_000_000, 4_000_000, 16_000_000)
TIMES = 5
"""How often each size is sent; the largest ones once."""

rclpy.init()
node = rclpy.create_node('client')


def wait_for(is_done: Callable[[], bool]) -> bool:
    end = time.monotonic() + PATIENCE_S
    while not is_done() and time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)
    return is_done()


def _has(items: Sized, count: int) -> bool:
    return len(items) >= count


def outcome(future: Any) -> Any:
    rclpy.spin_until_future_complete(node, future, timeout_sec=PATIENCE_S)
    return future.result()


def tell(what: str, right: int, of: int) -> None:
    print(f'{what} {right} of {of}', flush=True)


def call_service() -> None:
    clients = [node.create_client(SetBool, 'set') for _ in range(3)]
    is_there = all(client.wait_for_service(PATIENCE_S) for client in clients)
    right, times = 0, []
    for number in range(CALLS if is_there else 0):
        wants = number % 5 == 4
        before = time.perf_counter()
        response = outcome(clients[number % 3].call_async(SetBool.Request(data=wants)))
        times.append(time.perf_counter() - before)
        expected = 'long' * (min(LARGEST, 200_000) // 4) if wants else 'short'
        right += response is not None and response.success is wants and response.message == expected
    tell('services', right, CALLS)
    if times:
        first, *rest = times
        print(f'first {first * 1e3:.1f} ms, slowest other {max(rest) * 1e3:.1f} ms', flush=True)


def send_goals() -> None:
    client = ActionClient(node, Fibonacci, 'count')
    client.wait_for_server(PATIENCE_S)
    right = 0
    for number in range(GOALS):
        is_cancelled = number % 2 == 1
        feedback: list[Any] = []
        goal = outcome(
            client.send_goal_async(
                Fibonacci.Goal(order=500 if is_cancelled else 10),
                feedback_callback=feedback.append,
            )
        )
        if goal is None or not goal.accepted:
            continue
        if is_cancelled:
            wait_for(partial(_has, feedback, 2))
            outcome(goal.cancel_goal_async())
        result = outcome(goal.get_result_async())
        wanted = GoalStatus.STATUS_CANCELED if is_cancelled else GoalStatus.STATUS_SUCCEEDED
        is_right = result is not None and result.status == wanted and bool(feedback)
        if is_right and not is_cancelled:
            is_right = list(result.result.sequence)[-1] == 55 and len(feedback) == 9
        right += is_right
    tell('goals', right, GOALS)


def use_parameters() -> None:
    get = node.create_client(GetParameters, 'server/get_parameters')
    change = node.create_client(SetParameters, 'server/set_parameters')
    get.wait_for_service(PATIENCE_S)
    change.wait_for_service(PATIENCE_S)
    value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=2.5)
    before = outcome(get.call_async(GetParameters.Request(names=['gain'])))
    changed = outcome(
        change.call_async(SetParameters.Request(parameters=[Parameter(name='gain', value=value)]))
    )
    after = outcome(get.call_async(GetParameters.Request(names=['gain'])))
    tell(
        'parameters',
        (before is not None and before.values[0].double_value in (1.5, 2.5))
        + (changed is not None and changed.results[0].successful)
        + (after is not None and after.values[0].double_value == 2.5),
        3,
    )


def exchange() -> None:
    ping = node.create_publisher(String, 'ping', 100)
    came: list[str] = []
    latched: list[str] = []
    node.create_subscription(String, 'pong', lambda message: came.append(message.data), 100)
    qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(String, 'latched', lambda message: latched.append(message.data), qos)

    def greeted() -> bool:
        ping.publish(String(data='hello'))
        return bool(came)

    wait_for(greeted)
    texts = [
        f'{number} '.ljust(size, 'x')[:size]
        for size in SIZES
        for number in range(TIMES if size <= 1_000_000 else 1)
        if size <= LARGEST
    ]
    for text in texts:
        ping.publish(String(data=text))
        wait_for(partial(came.__contains__, text))
    tell('topics', sum(text in came for text in texts), len(texts))
    wait_for(lambda: bool(latched))
    tell('latched', int(latched == ['said before']), 1)


def compare_qos() -> None:
    """Hear each of the server's topics with each QoS: those come that offer what is asked for, no others."""
    policies = [
        (reliability, durability)
        for reliability in (ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT)
        for durability in (DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE)
    ]
    came: set[tuple[int, int]] = set()
    fitting = set()

    def note(pair: tuple[int, int], _: String) -> None:
        came.add(pair)

    for at, offered in enumerate(policies):
        topic = f'qos_{offered[0].name}_{offered[1].name}'.lower()
        for way, (reliability, durability) in enumerate(policies):
            asks_for_more = [
                reliability is ReliabilityPolicy.RELIABLE and offered[0] is ReliabilityPolicy.BEST_EFFORT,
                durability is DurabilityPolicy.TRANSIENT_LOCAL and offered[1] is DurabilityPolicy.VOLATILE,
            ]
            if not any(asks_for_more):
                fitting.add((at, way))
            qos = QoSProfile(depth=1, reliability=reliability, durability=durability)
            node.create_subscription(String, topic, partial(note, (at, way)), qos)
    wait_for(lambda: came >= fitting)
    end = time.monotonic() + SILENCE_S
    while time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)
    tell('qos', len(policies) ** 2 - len(came ^ fitting), len(policies) ** 2)


def hear_events() -> None:
    """Hear of a match, of a missed deadline, and of a QoS that does not fit."""
    heard: set[str] = set()
    beats: list[str] = []
    callbacks = SubscriptionEventCallbacks(
        matched=lambda _: heard.add('matched'), deadline=lambda _: heard.add('deadline')
    )
    qos = QoSProfile(depth=1, deadline=Duration(seconds=0.6), liveliness_lease_duration=Duration(seconds=4))
    node.create_subscription(
        String, 'beat', lambda message: beats.append(message.data), qos, event_callbacks=callbacks
    )
    strict = SubscriptionEventCallbacks(incompatible_qos=lambda _: heard.add('incompatible'))
    qos = QoSProfile(depth=1, deadline=Duration(seconds=0.1))
    node.create_subscription(String, 'beat', lambda _: heard.add('wrong'), qos, event_callbacks=strict)
    wait_for(lambda: bool(beats) and {'matched', 'incompatible'} <= heard)
    if 'deadline' in heard:
        heard.add('wrong')
    hush = node.create_client(SetBool, 'hush')
    hush.wait_for_service(PATIENCE_S)
    outcome(hush.call_async(SetBool.Request(data=True)))
    wait_for(lambda: 'deadline' in heard)
    tell('events', len({'matched', 'deadline', 'incompatible'} & heard) - ('wrong' in heard), 3)


def see_graph() -> None:
    def sees() -> bool:
        names = {
            f'{namespace.rstrip("/")}/{name}' for name, namespace in node.get_node_names_and_namespaces()
        }
        services = dict(node.get_service_names_and_types_by_node('server', '/')) if '/server' in names else {}
        return '/set' in services and '/count/_action/send_goal' in services

    tell('graph', int(wait_for(sees)), 1)


if 'no-graph' not in sys.argv:
    see_graph()
exchange()
call_service()
use_parameters()
send_goals()
compare_qos()
if 'no-events' not in sys.argv:
    hear_events()
node.destroy_node()
rclpy.try_shutdown()

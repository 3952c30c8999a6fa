"""Uses what `vendor_server.py` serves, on RustDDS by roswell; counts as `vendor_client.py` does."""

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

import roswell  # type: ignore[import-not-found]

CALLS, GOALS, LARGEST = map(int, sys.argv[2:])
PATIENCE_S = 20.0
SILENCE_S = 1.0
LONG = min(LARGEST, 200_000) // 4
CANCELED, SUCCEEDED = 5, 4

node = roswell.Node('client', domain=int(os.environ['ROS_DOMAIN_ID']), type_paths=[Path(sys.argv[1])])
String = node.load_type('std_msgs/msg/String')


def tell(what: str, right: int, of: int) -> None:
    print(f'{what} {right} of {of}', flush=True)


def say(publisher: roswell.Publisher, text: str) -> None:
    message = publisher.new()
    message.data = text
    publisher.publish(message)


def take(subscriber: roswell.Subscriber, within_s: float = PATIENCE_S) -> str | None:
    end = time.monotonic() + within_s
    while time.monotonic() < end:
        message = subscriber.take()
        if message is not None:
            return str(message.data)
        time.sleep(0.001)
    return None


def exchange() -> None:
    deep = roswell.QosProfile(depth=100)
    ping, pong = node.publisher('/ping', String, qos=deep), node.subscribe('/pong', String, qos=deep)
    latched = node.subscribe(
        '/latched', String, qos=roswell.QosProfile(depth=1, durability='transient_local')
    )
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        say(ping, 'hello')
        if take(pong, 0.1) is not None:
            break
    texts = [
        f'{number} '.ljust(size, 'x')[:size]
        for size in (2, 1000, 20_000)
        for number in range(5)
        if size <= LARGEST
    ]
    right = 0
    for text in texts:
        say(ping, text)
        found: str | None = 'hello'
        while found == 'hello':
            found = take(pong)
        right += found == text
    tell('topics', right, len(texts))
    tell('latched', int(take(latched) == 'said before'), 1)


def call_service() -> None:
    client = node.client('/set', *node.load_service('std_srvs/srv/SetBool'))
    right = 0
    time.sleep(SILENCE_S)
    for number in range(CALLS):
        wants = number % 5 == 4
        request = client.new_request()
        request.data = wants
        response = client.call_sync(request, timeout=PATIENCE_S)
        right += response.success is wants and response.message == ('long' * LONG if wants else 'short')
    tell('services', right, CALLS)


def send_goals() -> None:
    client = node.action_client('/count', 'example_interfaces/action/Fibonacci')
    client.wait_for_server(PATIENCE_S)
    right = 0
    for number in range(GOALS):
        is_cancelled = number % 2 == 1
        goal = client.new_goal()
        goal.order = 500 if is_cancelled else 10
        goal_id, is_accepted = client.send_goal_sync(goal, timeout=PATIENCE_S)
        feedback = [next(client.feedback(PATIENCE_S), None)]
        if is_cancelled:
            client.cancel_sync(goal_id, timeout=PATIENCE_S)
        status, result = client.get_result_sync(goal_id, timeout=PATIENCE_S)
        is_right = is_accepted and feedback[0] is not None
        is_right = is_right and status == (CANCELED if is_cancelled else SUCCEEDED)
        right += bool(is_right and (is_cancelled or list(result.sequence)[-1] == 55))
    tell('goals', right, GOALS)


USES: tuple[Callable[[], None], ...] = (exchange, call_service, send_goals)
for use in USES:
    use()
node.close()

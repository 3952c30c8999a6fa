"""relay, throttle and drop: republish one topic on another."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence

from rclpy.node import Node

from goalwire.apps.programs.running import UsageError, declare_text, spin_with_words
from goalwire.apps.programs.topic_tools.passing import Input, Output

RELAY_USAGE = 'INPUT [OUTPUT]'
THROTTLE_USAGE = 'messages INPUT MESSAGES_PER_S [OUTPUT]  |  bytes INPUT BYTES_PER_S WINDOW_S [OUTPUT]'
DROP_USAGE = 'INPUT X Y [OUTPUT]      (X of every Y messages are dropped)'


class Tool(Node):
    """Republishes messages of `input_topic` on `output_topic`, if `is_passed(size)` is True."""

    def __init__(self, name: str, source: str, target: str) -> None:
        super().__init__(name)
        source = declare_text(self, 'input_topic', source)
        target = declare_text(self, 'output_topic', target or f'{source}_{name}')
        if not source:
            raise UsageError('no input topic: name the topic to listen to')
        self._output = Output(self, target)
        self.is_passed: Callable[[int], bool] = lambda _size: True
        self._input = Input(self, source, self._output.open, self._take)

    def _take(self, serialized: bytes) -> None:
        if self.is_passed(len(serialized)):
            self._output.send(serialized)

    def steady_s(self) -> float:
        """Return the time of the node's clock in seconds."""
        return self.get_clock().now().nanoseconds / 1e9


def relay(argv: Sequence[str] | None = None) -> int:
    """Run relay."""
    return spin_with_words('relay', RELAY_USAGE, _make_relay, argv)


def throttle(argv: Sequence[str] | None = None) -> int:
    """Run throttle."""
    return spin_with_words('throttle', THROTTLE_USAGE, _make_throttle, argv)


def drop(argv: Sequence[str] | None = None) -> int:
    """Run drop."""
    return spin_with_words('drop', DROP_USAGE, _make_drop, argv)


def _make_relay(words: list[str]) -> Node:
    if len(words) > 2:
        raise UsageError(f'there are {len(words)} arguments; give an input and an output')
    source, target = [*words, '', ''][:2]
    return Tool('relay', source, target)


def _make_throttle(words: list[str]) -> Node:
    kind, *rest = words or ['']
    if kind == 'messages' and len(rest) in {2, 3}:
        rate = _number(rest[1], 'MESSAGES_PER_S')
        node = Tool('throttle', rest[0], [*rest, ''][2])
        node.is_passed = _by_count(node, rate)
    elif kind == 'bytes' and len(rest) in {3, 4}:
        rate, window = _number(rest[1], 'BYTES_PER_S'), _number(rest[2], 'WINDOW_S')
        node = Tool('throttle', rest[0], [*rest, ''][3])
        node.is_passed = _by_bytes(node, rate, window)
    else:
        raise UsageError("it needs the word 'messages' or 'bytes', a topic and a rate")
    return node


def _make_drop(words: list[str]) -> Node:
    if len(words) not in {3, 4}:
        raise UsageError('it needs a topic and two numbers')
    try:
        dropped, of = int(words[1]), int(words[2])
    except ValueError:
        raise UsageError(f"'{words[1]}' and '{words[2]}' are not two whole numbers") from None
    if not 0 <= dropped <= of or of == 0:
        raise UsageError(f'{dropped} of every {of} messages cannot be dropped')
    node = Tool('drop', words[0], [*words, ''][3])
    node.is_passed = _drop_some(dropped, of)
    return node


def _by_count(node: Tool, rate: float) -> Callable[[int], bool]:
    """Return a filter that passes a message if the last passed one is 1 / rate seconds old."""
    last = -math.inf

    def is_passed(_size: int) -> bool:
        nonlocal last
        now = node.steady_s()
        if now < last:
            last = -math.inf  # The clock jumped back, for example because a bag started again.
        if now - last < 1.0 / rate:
            return False
        last = now
        return True

    return is_passed


def _by_bytes(node: Tool, rate: float, window: float) -> Callable[[int], bool]:
    """Return a filter that passes a message if the bytes within the window then stay below the rate."""
    sent: deque[tuple[float, int]] = deque()

    def is_passed(size: int) -> bool:
        now = node.steady_s()
        if sent and now < sent[-1][0]:
            sent.clear()
        while sent and now - sent[0][0] > window:
            sent.popleft()
        if (sum(each for _, each in sent) + size) / window > rate:
            return False
        sent.append((now, size))
        return True

    return is_passed


def _drop_some(dropped: int, of: int) -> Callable[[int], bool]:
    count = 0

    def is_passed(_size: int) -> bool:
        nonlocal count
        place, count = count, (count + 1) % of
        return place >= dropped

    return is_passed


def _number(text: str, what: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0.0 < number < math.inf:
        raise UsageError(f"{what} is '{text}': it must be a number above 0")
    return number

"""tf2_monitor: prints the delays and rates of transforms."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Iterable, Sequence

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time
from tf2_msgs.msg import TFMessage
from tf2_ros import Buffer, TransformException, TransformListener

from goalwire.apps.programs.running import UsageError, spin_with_words

KEPT = 1000
"""How many of a frame's latest delays, and of the latest arrivals, the printed means are made of."""
REPORT_S = 10.0
SOMEBODY = '<no authority available>'
"""The text that ROS 2's tf2_monitor prints instead of a publisher's name, which it does not know."""


class Monitor(Node):
    """Prints a report every 10 s: of all frames, or of the chain between two of them."""

    def __init__(self, between: tuple[str, str] | None) -> None:
        super().__init__('tf2_monitor')
        self._between = between
        self._delays: dict[str, deque[float]] = {}  # the delays of each child frame, in s
        self._arrivals: deque[tuple[float, float]] = deque(
            maxlen=KEPT
        )  # time of arrival and mean delay, in s
        self._buffer = Buffer(node=self)
        self._listener = TransformListener(self._buffer, self)
        latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(TFMessage, '/tf', self._take, 100)
        self.create_subscription(TFMessage, '/tf_static', self._take, latched)
        self.create_timer(REPORT_S, self._report)
        if between is not None:
            print(f'Waiting for transform chain to become available between {between[0]} and {between[1]}')

    def _take(self, message: TFMessage) -> None:
        now = self._now()
        delays = []
        for transform in message.transforms:
            delay = now - Time.from_msg(transform.header.stamp).nanoseconds / 1e9
            self._delays.setdefault(transform.child_frame_id, deque(maxlen=KEPT)).append(delay)
            delays.append(delay)
        self._arrivals.append((now, _mean(delays)))

    def _report(self) -> None:
        shown = sorted(self._delays)
        if self._between is None:
            print('\n\n\nRESULTS: for all Frames')
        else:
            first, last = self._between
            try:
                chain = self._chain(first, last)
                stamp = self._buffer.lookup_transform(first, last, Time()).header.stamp
                net = self._now() - Time.from_msg(stamp).nanoseconds / 1e9
            except TransformException as error:
                print(f'Waiting for {first} to {last}: {error}', flush=True)
                return
            print(f'\n\n\nRESULTS: for {first} to {last}\nChain is: {" -> ".join(chain)}')
            print(f'Net delay     {net:.6g}')
            shown = [frame for frame in shown if frame in chain]
        print('\nFrames:')
        for frame in shown:
            delays = self._delays[frame]
            print(
                f'Frame: {frame}, published by {SOMEBODY}, '
                f'Average Delay: {_mean(delays):.6g}, Max Delay: {max(delays):.6g}'
            )
        print('\nAll Broadcasters:')
        if self._arrivals:
            span = max(self._arrivals[-1][0] - self._arrivals[0][0], 1e-8)
            delays = deque(delay for _, delay in self._arrivals)
            print(
                f'Node: {SOMEBODY} {len(self._arrivals) / span:.6g} Hz, '
                f'Average Delay: {_mean(delays):.6g} Max Delay: {max(delays):.6g}'
            )
        sys.stdout.flush()

    def _chain(self, first: str, last: str) -> list[str]:
        """Return the chain of frames between two frames, through their common parent."""
        up, down = self._ancestors(first), self._ancestors(last)
        common = next(frame for frame in up if frame in down)
        return [*up[: up.index(common) + 1], *reversed(down[: down.index(common)])]

    def _ancestors(self, frame: str) -> list[str]:
        import yaml

        frames = yaml.safe_load(self._buffer.all_frames_as_yaml()) or {}
        found = [frame]
        while (above := frames.get(found[-1])) and above['parent'] not in found:
            found.append(above['parent'])
        return found

    def _now(self) -> float:
        return self.get_clock().now().nanoseconds / 1e9


def _mean(numbers: Iterable[float]) -> float:
    listed = list(numbers)
    return sum(listed) / max(len(listed), 1)


def main(argv: Sequence[str] | None = None) -> int:
    """Run tf2_monitor."""
    return spin_with_words('tf2_monitor', '[FRAME_A FRAME_B]', _make, argv)


def _make(words: list[str]) -> Node:
    if not words:
        return Monitor(None)
    if len(words) != 2:
        raise UsageError('it needs two frames, or none for all of them')
    return Monitor((words[0], words[1]))

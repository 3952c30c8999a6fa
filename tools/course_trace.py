"""Traces the programs of the course's chapter, and draws what they say to each other as sequence diagrams.

python -m tools.course_trace     write docs/course/*.svg; a test compares them with a new trace

The programs of examples/course run unmodified, in a graph of their own and in virtual time: so every trace is
the same. An observer hears each step of each call, as a recorder does, and also feedback and log lines.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from time import sleep
from typing import Any, NamedTuple

from benchmarks import svg
from goalwire.testing import Graph, VirtualClock

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / 'docs' / 'course'
CLIENT, SERVER = 'client', 'server'
EVENTS = '/_service_event_for_recorders'
REQUEST_SENT, RESPONSE_SENT = 0, 2
A_MOMENT = 0.5
"""s of virtual time in which programs find each other, and all that they have begun comes to its end."""


ORDER = ('send_goal', 'cancel_goal', 'accepted', 'goals_canceling', 'get_result', 'feedback', 'result')
"""The order of an action's messages that have the same virtual time, as each causes the next."""


class Message(NamedTuple):
    """Something that one side has sent to the other, or has said itself."""

    at: float
    """s of virtual time, from the beginning of the trace."""
    sender: str
    receiver: str
    """The same as the sender for a line of its log."""
    text: str


class Trace:
    """Listens to one pair of programs."""

    def __init__(self, graph: Graph) -> None:
        import rclpy

        self.messages: list[Message] = []
        self._observer = rclpy.create_node('observer')
        graph.start(self._observer)
        self._began = self._now()

    def begin(self) -> None:
        """Count time from now on, once the programs have found each other; forget what was seen before."""
        sleep(A_MOMENT)
        self.messages.clear()
        self._began = self._now()

    def _now(self) -> float:
        nanoseconds: int = self._observer.get_clock().now().nanoseconds
        return nanoseconds / 1e9

    def watch_service(self, service_type: Any, name: str, show: Callable[[Any], str]) -> None:
        """Note requests and responses; `show` makes a few words of either."""

        def note(event: Any) -> None:
            at = _seconds(event.info.stamp)
            if event.info.event_type == REQUEST_SENT:
                self._note(at, CLIENT, SERVER, show(event.request[0]))
            elif event.info.event_type == RESPONSE_SENT:
                self._note(at, SERVER, CLIENT, show(event.response[0]))

        self._observer.create_subscription(service_type.Event, name + EVENTS, note, 100)

    def watch_topic(self, message_type: Any, topic: str, show: Callable[[Any], str]) -> None:
        """Note what the server publishes."""
        self._observer.create_subscription(
            message_type, topic, lambda message: self._note(self._now(), SERVER, CLIENT, show(message)), 100
        )

    def watch_log(self, server: str) -> None:
        """Note the log lines of the server's node."""
        from rcl_interfaces.msg import Log

        def note(line: Any) -> None:
            if line.name == server:
                self._note(_seconds(line.stamp), SERVER, SERVER, line.msg)

        self._observer.create_subscription(Log, '/rosout', note, 100)

    def _note(self, at: float, sender: str, receiver: str, text: str) -> None:
        self.messages.append(Message(round(at - self._began, 3), sender, receiver, text))


def _seconds(stamp: Any) -> float:
    return float(stamp.sec + stamp.nanosec / 1e9)


def _program(name: str) -> Any:
    """Import one of the chapter's programs."""
    return import_module(name)


@contextmanager
def _observed() -> Iterator[tuple[Graph, Trace]]:
    """Give a graph in virtual time, with rclpy in it and an observer."""
    os.environ.setdefault('GOALWIRE_INTERFACE_PATH', str(ROOT / 'robot'))
    sys.path.insert(0, str(ROOT / 'examples' / 'course'))
    try:
        with VirtualClock(), Graph() as graph:
            import rclpy

            rclpy.init(args=[], signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
            try:
                yield graph, Trace(graph)
            finally:
                rclpy.try_shutdown()
    finally:
        sys.path.remove(str(ROOT / 'examples' / 'course'))


def trace_service() -> list[Message]:
    """Return what the chapter's service client and server say to each other."""
    with _observed() as (graph, trace):
        from humanoid_interfaces.srv import GetJointState

        trace.watch_log('joint_state_service')
        trace.watch_service(GetJointState, '/get_joint_state', _show_joint)
        graph.start(_program('joint_state_service').JointStateService)
        client = _program('joint_state_client').JointStateClient()
        trace.begin()
        client.send_request('left_arm_shoulder')
        sleep(A_MOMENT)
        client.send_request('left_wing')
        sleep(A_MOMENT)
        client.destroy_node()
        return trace.messages


def trace_action(duration: float, cancel_after: float | None = None) -> list[Message]:
    """Return what the chapter's action client and server say about one goal, which may be cancelled."""
    with _observed() as (graph, trace):
        from humanoid_interfaces.action import MoveToPosition
        from rclpy.executors import MultiThreadedExecutor

        base: Any = _program('navigation_action_client').NavigationActionClient

        class Client(base):  # type: ignore[misc]  # written without types
            """Remembers its goal: the chapter's client never cancels."""

            def goal_response_callback(self, future: Any) -> None:
                self.goal_handle = future.result()
                super().goal_response_callback(future)

        implementation, action = MoveToPosition.Impl, '/move_to_position/_action'
        trace.watch_service(implementation.SendGoalService, f'{action}/send_goal', _show_goal)
        trace.watch_service(implementation.GetResultService, f'{action}/get_result', _show_result)
        trace.watch_service(implementation.CancelGoalService, f'{action}/cancel_goal', _show_cancel)
        trace.watch_topic(implementation.FeedbackMessage, f'{action}/feedback', _show_feedback)
        graph.start(
            _program('navigation_action_server').NavigationActionServer, executor=MultiThreadedExecutor
        )
        client = graph.start(Client)
        trace.begin()
        client.send_goal(1.0, 2.0, 0.0, timeout=duration)
        if cancel_after is not None:
            sleep(cancel_after)
            client.goal_handle.cancel_goal_async()
        sleep(duration + A_MOMENT)
        return sorted(trace.messages, key=lambda message: (message.at, ORDER.index(_kind(message))))


def _kind(message: Message) -> str:
    return re.split('[:=]', message.text)[0]


def _show_joint(message: Any) -> str:
    if hasattr(message, 'joint_name'):
        return f"request: joint_name='{message.joint_name}'"
    return f'response: position={message.position:g}, velocity={message.velocity:g}'


def _show_goal(message: Any) -> str:
    if hasattr(message, 'goal'):
        place = message.goal.target_pose.pose.position
        return f'send_goal: x={place.x:g}, y={place.y:g}, timeout={message.goal.timeout:g}'
    return f'accepted={message.accepted}'


def _show_result(message: Any) -> str:
    if hasattr(message, 'result'):
        names = {4: 'SUCCEEDED', 5: 'CANCELED', 6: 'ABORTED'}
        return f"result: {names[message.status]}, message='{message.result.message}'"
    return 'get_result'


def _show_cancel(message: Any) -> str:
    if hasattr(message, 'goal_info'):
        return 'cancel_goal'
    return f'goals_canceling: {len(message.goals_canceling)}'


def _show_feedback(message: Any) -> str:
    return f'feedback: distance_remaining={message.feedback.distance_remaining:.2f}'


def draw(title: str, messages: list[Message]) -> str:
    """Return a sequence diagram."""
    top, step, places = 64, 28, {CLIENT: 150.0, SERVER: 560.0}
    bottom = top + step * len(messages)
    parts = [svg.text(10, 20, title, colour='#777')]
    for side, x in places.items():
        parts += [svg.text(x, top - 22, side, anchor='middle', colour='#777')]
        parts += [svg.line(x, top - 14, x, bottom, opacity=0.6)]
    for index, message in enumerate(messages):
        y = top + step * index + 8
        begin, end = places[message.sender], places[message.receiver]
        parts.append(svg.text(10, y + 4, f'{message.at:.1f} s'))
        if begin == end:
            parts += [svg.dot(begin, y, '#7f7f7f', message.text), svg.text(begin + 10, y + 4, message.text)]
            continue
        colour = svg.COLOURS[0] if message.sender == CLIENT else svg.COLOURS[2]
        back = -7 if end > begin else 7
        parts += [svg.line(begin, y, end, y, colour=colour, opacity=1.0)]
        parts += [f'<path d="M{end:.1f} {y:.1f}l{back} -4v8z" fill="{colour}"/>']
        parts += [svg.text((begin + end) / 2, y - 5, message.text, anchor='middle', colour='#777')]
    return svg.page(820, bottom + 16, parts)


def pictures() -> dict[Path, str]:
    """Return the diagrams by their files, each from a new trace."""
    return {
        PICTURES / 'service.svg': draw(
            'Two calls of a service: the second one is about no joint', trace_service()
        ),
        PICTURES / 'action.svg': draw('A goal, its feedback and its result', trace_action(0.4)),
        PICTURES / 'cancellation.svg': draw('A goal that is cancelled on its way', trace_action(30.0, 0.25)),
    }


if __name__ == '__main__':
    for file, text in pictures().items():
        file.write_text(text, encoding='utf-8')

"""The calls and goals of a bag, assembled from their service events.

A bag may have the events of both sides of a call. The server's events are used if there are any, because they
have the order in which the server saw all requests; otherwise the client's events are used.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any

from goalwire.apps.bag.selection import Selection, action_of
from goalwire.cdr.codec import encoder
from goalwire.rosbag2.model import SERVICE_EVENT, Topic
from goalwire.rosbag2.reader import Reader

_REQUESTS = (0, 1)
_SERVER = (1, 2)
"""Event types in service_msgs/msg/ServiceEventInfo: those of requests, and those that servers publish."""
_ALL_GOALS = bytes(16)


class RecordedCall:
    """One call; times in ns of the bag."""

    def __init__(self, service: str, type_name: str, request: Any, sent: int) -> None:
        self.service = service
        self.type_name = type_name
        """The type, as 'pkg/srv/Name'."""
        self.request = request
        self.sent = sent
        self.response: Any = None
        """The response; None if the bag has none."""
        self.ended = 0
        """The time of the response; 0 if the bag has none."""

    @property
    def name(self) -> str:
        """The service's name."""
        return self.service


class RecordedGoal:
    """One goal, from its sending to its result; times in ns of the bag."""

    def __init__(self, action: str, type_name: str, call: RecordedCall) -> None:
        self.name = action
        self.type_name = type_name
        """The type, as 'pkg/action/Name'."""
        self.goal_id = bytes(call.request.goal_id.uuid)
        self.goal = call.request.goal
        self.sent = call.sent
        self.answered = call.ended
        self.is_accepted: bool | None = None if call.response is None else call.response.accepted
        """True if the server accepted the goal; None if the bag has no response to the goal."""
        self.feedback: list[tuple[int, Any]] = []
        """The times and messages of the goal's feedback."""
        self.cancels: list[int] = []
        """The times of the requests to cancel the goal."""
        self.status = 0
        """An action_msgs/msg/GoalStatus; 0 if the bag has no result."""
        self.result: Any = None
        self.ended = 0

    def feedback_before(self, time: int) -> int:
        """Return how many feedback messages came before a time."""
        return sum(at < time for at, _ in self.feedback)


Recorded = RecordedCall | RecordedGoal


def read_recorded(bag: Reader, selection: Selection | None = None) -> list[Recorded]:
    """Return the calls and goals of a bag, in the order in which they were sent.

    Raises BagError, and InterfaceError for a type that is neither known here nor defined in the bag.
    """
    calls = _read_calls(bag, selection)
    goals = _goals_of(bag, calls, selection)
    plain = [call for call in calls if not action_of(call.service + SERVICE_EVENT)]
    return sorted((*plain, *goals), key=lambda each: each.sent)


def _choose_topics(bag: Reader, selection: Selection | None, ending: str) -> Iterator[Topic]:
    for topic in bag.topics:
        is_wanted = selection is None or selection.wants(topic.name, topic.type_name)
        if topic.name.endswith(ending) and is_wanted and bag.counts.get(topic.name):
            yield topic


def _read_calls(bag: Reader, selection: Selection | None) -> list[RecordedCall]:
    types = {topic.name: topic.type_name for topic in _choose_topics(bag, selection, SERVICE_EVENT)}
    sides: dict[tuple[str, bool], dict[tuple[bytes, int], RecordedCall]] = defaultdict(dict)
    for message, event in bag.decoded(list(types)) if types else ():
        step, key = event.info.event_type, (bytes(event.info.client_gid), event.info.sequence_number)
        calls = sides[message.topic, step in _SERVER]
        if step in _REQUESTS and len(event.request):
            service, type_name = message.topic.removesuffix(SERVICE_EVENT), types[message.topic]
            call = RecordedCall(service, type_name.removesuffix('_Event'), event.request[0], message.time)
            calls[key] = call
        elif key in calls and len(event.response):
            calls[key].response, calls[key].ended = event.response[0], message.time
    return [call for name in types for call in (sides[name, True] or sides[name, False]).values()]


def _goals_of(bag: Reader, calls: list[RecordedCall], selection: Selection | None) -> list[RecordedGoal]:
    goals: dict[bytes, RecordedGoal] = {}
    for call in calls:
        action, _, part = call.service.partition('/_action/')
        if part == 'send_goal':
            goal = RecordedGoal(action, call.type_name.removesuffix('_SendGoal'), call)
            goals[goal.goal_id] = goal
    for call in calls:
        part = call.service.partition('/_action/')[2]
        if part == 'get_result' and call.response is not None:
            _note_result(goals.get(bytes(call.request.goal_id.uuid)), call)
        elif part == 'cancel_goal':
            _note_cancel(goals, call)
    topics = [topic.name for topic in _choose_topics(bag, selection, '/_action/feedback')]
    for message, feedback in bag.decoded(topics) if topics else ():
        found = goals.get(bytes(feedback.goal_id.uuid))
        if found is not None:
            found.feedback.append((message.time, feedback.feedback))
    return list(goals.values())


def _note_result(goal: RecordedGoal | None, call: RecordedCall) -> None:
    if goal is not None and not goal.ended:
        goal.status, goal.result, goal.ended = call.response.status, call.response.result, call.ended


def _note_cancel(goals: dict[bytes, RecordedGoal], call: RecordedCall) -> None:
    """Add a cancel request to the goals that it names, or that the server cancelled because of it."""
    meant = {bytes(call.request.goal_info.goal_id.uuid)}
    if call.response is not None:
        meant |= {bytes(info.goal_id.uuid) for info in call.response.goals_canceling}
    for goal_id in meant - {_ALL_GOALS}:
        if goal_id in goals:
            goals[goal_id].cancels.append(call.sent)


def content_of(message: Any) -> bytes:
    """Return the bytes of a message, as a key for finding equal messages."""
    cls: type = type(message)
    return encoder(cls)(message)

"""Rates, latencies, series, goals, logs and pictures: what the page shows, without a page."""

from __future__ import annotations

import asyncio
import math
import shlex
import zlib
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from example_interfaces.srv import AddTwoInts
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.msg import Log
from rosidl_runtime_py import message_to_ordereddict
from sensor_msgs.msg import CompressedImage, Image, JointState
from service_msgs.msg import ServiceEventInfo

import goalwire
from goalwire.apps.cli.framework.values import fill, read_values
from goalwire.apps.console.goal_table import KEPT, GoalTable, lanes
from goalwire.apps.console.graph_layout import HEIGHT, WIDTH, arranged
from goalwire.apps.console.images import as_data_url, png
from goalwire.apps.console.logs import LogBook
from goalwire.apps.console.measuring import Latencies, Rate, Series, as_csv, numbers_in, signed
from goalwire.apps.console.sending import Target
from goalwire.apps.console.service_events import KEPT as KEPT_CALLS
from goalwire.apps.console.service_events import ServiceEvents
from goalwire.apps.console.snippets import as_command, as_python
from goalwire.apps.console.types import as_data
from goalwire.errors import RemoteError
from goalwire.idl.registry import register_definitions

# -- measuring -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize('hertz', [0.2, 1.0, 10.0, 400.0])
@pytest.mark.parametrize('phase', [0.0, 0.3, 0.999])
def test_a_rate_is_right_whenever_it_is_told(hertz: float, phase: float) -> None:
    """It is read each second, beginning before the first message, which comes at any time."""
    rate = Rate()
    first = 3.0 + phase
    told: list[float | None] = []
    for second in range(60):
        if second >= first:
            count = int((second - first) * hertz) + 1
            rate.note(count, first + (count - 1) / hertz)
        told.append(rate.told(second))
    known = [each for each in told if each is not None]
    assert known == pytest.approx([hertz] * len(known))
    assert len(known) >= 60 - first - 2 - 2 / hertz, 'it is told from the second reading on'


def test_a_rate_follows_the_last_seconds_and_stops_with_the_messages() -> None:
    rate = Rate()
    for second in range(10):
        rate.note(20 * second, second)
    for second in range(10, 20):
        rate.note(180 + 5 * (second - 9), second)
    assert rate.told(19) == pytest.approx(5.0)
    assert rate.told(22) == pytest.approx(5.0), 'the next may come yet'
    assert rate.told(22.1) == 0.0
    assert rate.told(30) == 0.0
    rate.note(231, 31.0)
    assert rate.told(31) is None
    rate.note(241, 32.0)
    assert rate.told(32) == pytest.approx(10.0)


def test_of_one_message_or_of_a_burst_no_rate_is_told() -> None:
    rate = Rate()
    assert rate.told(0.0) is None
    rate.note(1, 1.0)
    assert rate.told(100.0) is None
    burst = Rate()
    burst.note(1, 0.99)
    burst.note(5, 1.01)
    assert burst.told(1.01) is None


def test_percentiles_are_those_of_the_nearest_rank() -> None:
    latencies = Latencies()
    assert (latencies.percentile(0.5), latencies.histogram()) == (0.0, ([], []))
    for number in range(1, 101):
        latencies.note(number / 1000)
    assert [latencies.percentile(share) for share in (0.5, 0.95, 0.99, 1.0)] == [0.05, 0.095, 0.099, 0.1]
    edges, counts = latencies.histogram(8)
    assert (len(edges), sum(counts)) == (9, 100)
    assert edges == sorted(edges)


def test_a_ring_keeps_the_latest_and_no_peak_is_lost() -> None:
    series = Series('x', capacity=1000)
    for number in range(2500):
        series.append(float(number), 99.0 if number == 1999 else 0.0)
    times, _ = series.arrays()
    assert (len(series), times[0], times[-1]) == (1000, 1500.0, 2499.0)
    points = series.points(0.0, 100)
    assert len(points) <= 100
    assert (1999.0, 99.0) in points
    assert [time for time, _ in series.points(2490.0)] == list(range(2490, 2500))


def test_csv_holds_every_value_and_no_formula() -> None:
    series = Series('=cmd()')
    series.append(1.5, 2.25)
    assert as_csv([series]).splitlines() == ['series,time,value', "'=cmd(),1.5,2.25"]
    assert as_csv([series], 1e9).splitlines()[1] == "'=cmd(),1000000001.5,2.25"


def test_nothing_is_minus_nought() -> None:
    assert [signed(number) for number in (-0.001, 0.0, -0.006, 1.239)] == ['+0.00', '+0.00', '-0.01', '+1.24']


def test_every_number_of_a_message_can_be_plotted() -> None:
    found = dict(numbers_in(JointState(name=['a'], position=[1.0, 2.0])))
    assert (found['position[1]'], 'name[0]' in found) == (2.0, False)
    assert dict(numbers_in(PoseStamped()))['pose.orientation.w'] == 1.0


def test_messages_become_data_that_json_can_hold() -> None:
    data = as_data(JointState(name=['x' * 5000], position=[float('nan'), *range(500)]))
    assert data['position'][0] == 'nan'
    assert len(data['position']) == 201
    assert data['position'][-1] == '… 501 items'
    assert len(data['name'][0]) < 2100
    assert as_data(2**60) == str(2**60)
    octets = as_data(bytes(1_000_000))
    assert (len(octets), octets[-1]) == (201, '… 1000000 items')


# -- goals ---------------------------------------------------------------------------------------------------


def test_goals_of_everybody_are_followed_to_their_end() -> None:
    table = GoalTable()
    mine = table.note_sent('/go', 'aa', {'x': 1.0}, 10.0)
    assert [goal.goal_id for goal in table.take_statuses('/go', [('aa', 2, 9.9), ('bb', 1, 9.8)], 11.0)] == [
        'aa',
        'bb',
    ]
    table.take_feedback('/go', 'aa', {'distance_remaining': 4.0}, 12.0)
    table.take_feedback('/go', 'aa', {'distance_remaining': 1.0}, 13.0)
    other = table.get('/go', 'bb')
    assert other is not None
    assert (mine.is_mine, other.is_mine, mine.progress, list(mine.ticks)) == (True, False, 0.75, [12.0, 13.0])
    table.take_statuses('/go', [('aa', 4, 9.9), ('bb', 6, 9.8)], 14.0)
    assert (mine.status, mine.ended, mine.progress, other.status) == ('SUCCEEDED', 14.0, 1.0, 'ABORTED')
    assert table.take_statuses('/go', [('aa', 2, 9.9)], 15.0) == []  # late news of a goal that has ended
    assert table.active() == []


def test_an_answer_that_comes_behind_the_status_changes_nothing() -> None:
    table = GoalTable()
    goal = table.note_sent('/go', 'aa', {}, 1.0)
    table.take_statuses('/go', [('aa', 2, 1.0)], 1.1)
    assert not goal.move('ACCEPTED', 1.2)
    assert goal.status == 'EXECUTING'


def test_a_goal_that_had_ended_before_it_was_seen_is_a_moment_of_the_past() -> None:
    table = GoalTable()
    table.take_statuses('/go', [('aa', 4, 100.0)], 500.0)
    goal = table.get('/go', 'aa')
    assert goal is not None
    assert (goal.began, goal.ended) == (100.0, 100.0)


def test_a_servers_stamp_becomes_a_reading_of_the_monotonic_clock() -> None:
    table = GoalTable()
    table.take_statuses('/go', [('aa', 2, 1_000_100.0), ('bb', 2, 1_000_900.0)], 500.0, 1_000_000.0)
    began = [goal.began for goal in table]
    assert began == [100.0, 500.0], 'one that a clock ahead of ours stamped began now'
    assert [goal.accepted for goal in table] == [1_000_100.0, 1_000_900.0]


@pytest.mark.parametrize(
    ('feedback', 'progress'),
    [({'fraction_done': 0.4}, 0.4), ({'percent': 40.0}, 0.4), ({'progress': 3.0}, 1.0), ({'x': 1.0}, None)],
)
def test_progress_is_read_from_fields_that_say_it(feedback: dict[str, Any], progress: float | None) -> None:
    assert GoalTable().take_feedback('/a', 'x', feedback, 0.0).progress == progress


def test_old_goals_go_and_active_ones_stay() -> None:
    table = GoalTable()
    table.take_statuses('/a', [('first', 2, 0.0)], 0.0)
    for number in range(KEPT + 50):
        table.take_statuses('/a', [(f'{number}', 4, 1.0)], 1.0)
    assert len(table) == KEPT
    assert table.get('/a', 'first') is not None


def test_goals_that_overlap_have_lanes_of_their_own() -> None:
    table = GoalTable()
    for goal_id, began, ended in (('a', 0.0, 5.0), ('b', 1.0, 3.0), ('c', 4.0, 6.0), ('d', 5.5, None)):
        goal = table.note_sent('/a', goal_id, {}, began)
        if ended is not None:
            table.end(goal, 'ABORTED', '', ended)
    assert [(goal.goal_id, row) for goal, row in lanes(table, 7.0)] == [
        ('a', 0),
        ('b', 1),
        ('c', 1),
        ('d', 0),
    ]
    assert [row for _, row in lanes(table, 7.0, margin=2.0)] == [0, 1, 2, 1]


# -- logs ----------------------------------------------------------------------------------------------------


def test_log_lines_are_found_by_level_node_and_text() -> None:
    book = LogBook()
    for number in range(20):
        level = 40 if number % 10 == 0 else 20
        book.take(Log(level=level, name='arm' if number % 2 else 'leg', msg=f'line {number}'))
    assert [line.text for line in book.latest(3)] == ['line 19', 'line 18', 'line 17']
    assert [line.text for line in book.latest(9, least_level=40)] == ['line 10', 'line 0']
    assert len(book.latest(99, node='arm')) == 10
    assert [line.text for line in book.latest(99, text='LINE 1')][-1] == 'line 1'
    assert book.nodes == ['arm', 'leg']


def test_log_lines_of_any_size_are_cut_and_say_so() -> None:
    book = LogBook()
    size = 10_000_000
    book.take(Log(level=20, name='n' * size, msg='m' * size, file='f' * size, function='g' * size))
    [line] = book.latest(1)
    assert line.text == 'm' * 4000 + '… (10000000 characters)'
    assert len(line.node) + len(line.place) < 1000


# -- pictures ------------------------------------------------------------------------------------------------


def decoded(file: bytes, width: int, height: int, channels: int) -> np.ndarray[Any, Any]:
    start = file.index(b'IDAT') + 4
    size = int.from_bytes(file[start - 8 : start - 4], 'big')
    lines = np.frombuffer(zlib.decompress(file[start : start + size]), np.uint8)
    return lines.reshape(height, width * channels + 1)[:, 1:].reshape(height, width, channels)


def test_a_png_holds_the_pixels() -> None:
    pixels = np.arange(4 * 5 * 3, dtype=np.uint8).reshape(4, 5, 3)
    assert (decoded(png(pixels), 5, 4, 3) == pixels).all()


@pytest.mark.parametrize(
    ('encoding', 'size'), [('rgb8', 3), ('bgra8', 4), ('mono8', 1), ('mono16', 2), ('32FC1', 4)]
)
def test_pictures_of_known_encodings_are_shown(encoding: str, size: int) -> None:
    message = Image(height=2, width=3, step=3 * size + 1, encoding=encoding, data=bytes(2 * (3 * size + 1)))
    assert as_data_url(message).startswith('data:image/png;base64,')


@pytest.mark.parametrize(
    'message',
    [
        Image(height=2, width=3, step=9, encoding='rgb8', data=bytes(17)),
        Image(height=2**31, width=2**31, step=9, encoding='rgb8', data=bytes(17)),
        Image(height=0, width=0, encoding='rgb8'),
        Image(height=1, width=1, step=3, encoding='<script>', data=bytes(3)),
        CompressedImage(format='svg', data=b'<svg onload="x()">'),
    ],
)
def test_pictures_that_are_none_are_refused(message: Any) -> None:
    with pytest.raises(RemoteError):
        as_data_url(message)


def test_a_jpeg_is_passed_on() -> None:
    given = SimpleNamespace(format='jpeg', data=b'\xff\xd8\xff\xe0abc')
    assert as_data_url(given).startswith('data:image/jpeg;base64,')


# -- sending -------------------------------------------------------------------------------------------------


def test_attempts_share_the_deadline_and_are_copied_with_the_call() -> None:
    sending = Target('service', '/lamp', 'std_srvs/srv/SetBool').sending({'data': True}, 6.0, 3)
    assert sending.retry == goalwire.Retry(attempts=3, timeout=2.0)
    assert 'retry=goalwire.Retry(attempts=3, timeout=2.0))' in as_python(sending)
    assert 'message, timeout=6.0' in as_python(sending)
    once = Target('service', '/lamp', 'std_srvs/srv/SetBool').sending({'data': True}, 6.0)
    assert once.retry is None
    assert 'Retry' not in as_python(once)


NOW = {'stamp': 'now', 'frame_id': 'map'}


@pytest.mark.parametrize(
    ('kind', 'type_name', 'values', 'stamped'),
    [
        ('topic', 'geometry_msgs/msg/PoseStamped', {'header': NOW}, ['header.stamp']),
        ('topic', 'geometry_msgs/msg/PoseStamped', {'header': 'auto'}, ['header.stamp']),
        ('topic', 'sensor_msgs/msg/TimeReference', {'time_ref': 'auto'}, ['time_ref']),
        ('topic', 'nav_msgs/msg/Path', {'poses': [{'header': NOW}, {}]}, ['poses.0.header.stamp']),
        ('service', 'nav_msgs/srv/GetPlan', {'start': {'header': NOW}}, ['start.header.stamp']),
        (
            'action',
            'control_msgs/action/FollowJointTrajectory',
            {'trajectory': {'header': {'stamp': 'auto'}}},
            ['trajectory.header.stamp'],
        ),
    ],
)
def test_a_copied_command_sends_the_time_of_its_sending(
    kind: str, type_name: str, values: dict[str, Any], stamped: list[str]
) -> None:
    """As the form gives it, in words of a shell, and as the command reads those."""
    target = Target(kind, '/name', type_name)
    words = shlex.split(as_command(target.sending(values)))
    assert words[-2] == type_name
    message = target.message_class()
    set_stamps = fill(message, read_values(words[-1:], target.message_class), type_name)
    assert len(set_stamps) == len(stamped)
    for set_stamp in set_stamps:
        set_stamp(Time(sec=1_700_000_000, nanosec=5))
    whole = message_to_ordereddict(message)
    for path in stamped:
        found: Any = whole
        for part in path.split('.'):
            found = found[int(part) if part.isdigit() else part]
        assert dict(found) == {'sec': 1_700_000_000, 'nanosec': 5}


def test_two_classes_of_one_name_are_copied_under_two_names() -> None:
    register_definitions('console_first', {'msg/Part': 'float64 size\n'})
    register_definitions(
        'console_second', {'msg/Part': 'console_first/Part[] parts\nconsole_first/Part part\nstring name\n'}
    )
    values = {'name': 'b', 'part': {'size': 2}, 'parts': [{'size': 3}]}
    text = as_python(Target('topic', '/parts', 'console_second/msg/Part').sending(values))
    assert 'from console_first.msg import Part as console_first_msg_Part\n' in text
    [line] = [line for line in text.splitlines() if 'message = ' in line]
    names: dict[str, Any] = {}
    imports = '\n'.join(line for line in text.splitlines() if line.startswith('from '))
    exec(imports, names)
    message = eval(line.partition('=')[2], names)
    assert (message.name, message.part.size, [part.size for part in message.parts]) == ('b', 2.0, [3.0])


# -- calls of others -----------------------------------------------------------------------------------------


def test_calls_are_put_together_from_their_events() -> None:
    events = ServiceEvents()

    def step(number: int, second: int, **contents: Any) -> None:
        info = ServiceEventInfo(
            event_type=number,
            stamp=Time(sec=second),
            client_gid=np.arange(16, dtype=np.uint8),
            sequence_number=7,
        )
        events.take(AddTwoInts.Event(info=info, **contents))

    step(0, 10, request=[AddTwoInts.Request(a=1, b=2)])
    step(1, 12)
    [call] = events.latest
    assert (call.state, call.request, call.response, call.served_in) == (
        'request received',
        {'a': 1, 'b': 2},
        None,
        None,
    )
    step(2, 15, response=[AddTwoInts.Response(sum=3)])
    step(3, 16)
    step(9, 99)
    assert (call.state, call.response, call.served_in, call.took) == (
        'response received',
        {'sum': 3},
        3.0,
        6.0,
    )
    for number in range(2 * KEPT_CALLS):
        events.take(AddTwoInts.Event(info=ServiceEventInfo(sequence_number=number)))
    assert len(events.latest) == KEPT_CALLS


# -- the graph -----------------------------------------------------------------------------------------------


def test_a_drawing_has_room_for_all_and_keeps_its_places() -> None:
    names = ['robot', *(f'topic {number}' for number in range(40)), 'other', 'far']
    links = [('robot', name) for name in names[1:41]] + [('other', 'far')]
    places = arranged(names, links, {})
    assert all(0 <= x <= WIDTH and 0 <= y <= HEIGHT for x, y in places.values())
    assert len({(round(x, 2), round(y, 2)) for x, y in places.values()}) > 40
    assert math.dist(places['other'], places['far']) < math.dist(places['other'], places['robot'])
    assert arranged(names, links, {}) == places
    later = arranged([*names, 'new'], [*links, ('new', 'other')], places)
    assert max(math.dist(places[name], later[name]) for name in names) < 0.5
    assert (arranged([], [], {}), len(arranged(['one'], [], {}))) == ({}, 1)


# -- the pace ------------------------------------------------------------------------------------------------


@pytest.mark.timeout(300)  # the library of the page takes long to import where the machine is busy
def test_a_browser_that_does_not_answer_is_sent_no_second_refresh() -> None:
    pytest.importorskip('nicegui')
    from goalwire.apps.console.page.view import Page

    refreshed = 0
    asked = 0

    class Silent(nullcontext[None]):
        """A browser that answers the fourth time it is asked."""

        async def connected(self) -> None:
            pass

        async def run_javascript(self, _code: str, **_timeout: float) -> int:
            nonlocal asked
            asked += 1
            if asked < 4:
                raise TimeoutError
            assert refreshed == 1
            page.closed = True
            return 1

    def refresh() -> None:
        nonlocal refreshed
        refreshed += 1

    page = Page(cast('Any', Silent()), cast('Any', None))
    page.header = refresh
    asyncio.run(page.pace())
    assert (asked, refreshed) == (4, 1)

"""Series, pictures, forms and drawings: what the page shows, without a page."""

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
from geometry_msgs.msg import PoseStamped
from rosidl_runtime_py import message_to_ordereddict
from sensor_msgs.msg import CompressedImage, Image, JointState

import goalwire
from goalwire.apps.cli.framework.values import fill, read_values
from goalwire.apps.console.state.graph_layout import HEIGHT, WIDTH, arrange
from goalwire.apps.console.state.sending import Target
from goalwire.apps.console.state.series import Series, as_csv, name_joint, number_at, put_sign
from goalwire.apps.console.state.snippets import as_command, as_python
from goalwire.errors import RemoteError
from goalwire.idl.pictures import as_data_url
from goalwire.idl.png import png
from goalwire.idl.registry import register_definitions

# -- series --------------------------------------------------------------------------------------------------


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
    assert [put_sign(number) for number in (-0.001, 0.0, -0.006, 1.239)] == [
        '+0.00',
        '+0.00',
        '-0.01',
        '+1.24',
    ]


def test_a_plot_of_a_joint_follows_its_name() -> None:
    message = JointState(name=['a', 'b'], position=[1.0, 2.0])
    assert name_joint('position[1]', message) == 'position[b]'
    read = number_at('position[b]')
    assert read(message) == 2.0
    assert read(JointState(name=['b'], position=[3.0])) == 3.0
    assert read(JointState(name=['a'], position=[3.0])) is None
    assert number_at('position[1]')(message) == 2.0
    assert name_joint('position[7]', message) == 'position[7]'
    assert name_joint('position[0]', JointState(name=['1', '2'])) == 'position[0]', 'a name that is a number'
    assert name_joint('position[0]', JointState(name=['a', 'a'])) == 'position[0]', 'two of one name'
    assert name_joint('pose.orientation.w', PoseStamped()) == 'pose.orientation.w'


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


# -- the graph -----------------------------------------------------------------------------------------------


def test_a_drawing_has_room_for_all_and_keeps_its_places() -> None:
    names = ['robot', *(f'topic {number}' for number in range(40)), 'other', 'far']
    links = [('robot', name) for name in names[1:41]] + [('other', 'far')]
    places = arrange(names, links, {})
    assert all(0 <= x <= WIDTH and 0 <= y <= HEIGHT for x, y in places.values())
    assert len({(round(x, 2), round(y, 2)) for x, y in places.values()}) > 40
    assert math.dist(places['other'], places['far']) < math.dist(places['other'], places['robot'])
    assert arrange(names, links, {}) == places
    later = arrange([*names, 'new'], [*links, ('new', 'other')], places)
    assert max(math.dist(places[name], later[name]) for name in names) < 0.5
    assert (arrange([], [], {}), len(arrange(['one'], [], {}))) == ({}, 1)


# -- the pace ------------------------------------------------------------------------------------------------


@pytest.mark.timeout(300)  # the library of the page takes long to import where the machine is busy
def test_a_browser_that_does_not_answer_is_sent_no_second_refresh() -> None:
    pytest.importorskip('nicegui')
    from goalwire.apps.console.page.view import Page

    refreshed = 0
    asked = 0

    class Silent(nullcontext[None]):
        """A browser that answers the fourth time it is asked."""

        request = None

        async def connected(self) -> None:
            pass

        async def run_javascript(self, _code: str, **_timeout: float) -> int:
            nonlocal asked
            asked += 1
            if asked < 4:
                raise TimeoutError
            assert refreshed == 1
            page.close()
            return 1

    def refresh() -> None:
        nonlocal refreshed
        refreshed += 1

    everybody = SimpleNamespace(problem=lambda: '')
    session = SimpleNamespace(rights_of=lambda _who: everybody)
    page = Page(cast('Any', Silent()), cast('Any', session))
    page.header = refresh
    asyncio.run(page.pace())
    assert (asked, refreshed) == (4, 1)

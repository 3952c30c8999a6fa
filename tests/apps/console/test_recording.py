"""Recordings without a page: what was at a time, wherever one comes from, and how the playhead moves."""

from __future__ import annotations

import asyncio
import math
import random
from pathlib import Path
from typing import Any

import pytest
from helpers.bags import START, write_bag
from helpers.patience import BROWSER
from helpers.recorded_robot import GOALS, SECONDS, SPEED, write_recorded_robot

from goalwire.apps.console.state.playhead import Playhead
from goalwire.apps.console.state.recorded_moment import Moment, Moments
from goalwire.apps.console.state.recorded_plot import SPANS, Outline, RecordedPlot
from goalwire.apps.console.state.recording import Recording
from goalwire.apps.console.state.series import number_at
from goalwire.errors import BagError
from goalwire.rosbag2.writer import Writer

SECOND = 1_000_000_000


@pytest.fixture(params=['mcap', 'sqlite3'])
def recording(request: pytest.FixtureRequest, tmp_path: Path) -> Recording:
    return Recording(str(write_recorded_robot(tmp_path / 'robot', storage=request.param)))


class Reading:
    """Moments that are waited for."""

    def __init__(self, recording: Recording) -> None:
        self._changed = asyncio.Event()
        self.moments = Moments(recording, self._changed.set)

    async def at(self, seconds: float, topic: str = '') -> Moment:
        time = START + round(seconds * SECOND)
        self.moments.want(time, '', topic)
        async with asyncio.timeout(BROWSER):
            while self.moments.latest is None or self.moments.latest.time != time:
                self._changed.clear()
                await self._changed.wait()
        return self.moments.latest


def moments(recording: Recording, *seconds: float, topic: str = '') -> list[Moment]:
    async def read() -> list[Moment]:
        reading = Reading(recording)
        try:
            return [await reading.at(each, topic) for each in seconds]
        finally:
            reading.moments.close()

    return asyncio.run(read())


def test_the_robot_is_where_it_was_after_jumps_in_both_directions(recording: Recording) -> None:
    """Its description and /tf_static were sent once, at the start: they count after each jump."""
    times = random.Random(7).sample(range(SECONDS), 20)
    for at, moment in zip(times, moments(recording, *times), strict=True):
        assert moment.model is not None
        assert moment.frame == 'map'
        assert moment.base is not None
        assert math.isclose(moment.base.translation[0], 1.0 + SPEED * at, abs_tol=1e-6)
        assert dict(moment.links).keys() >= {'base_link', 'left_arm'}


def test_a_jump_shows_the_same_as_playing_to_that_time(recording: Recording) -> None:
    played = moments(recording, *(number / 2 for number in range(60)), 30.0)[-1]
    [jumped] = moments(recording, 30.0)
    assert jumped.links == played.links
    assert [line.text for line in jumped.lines][:5] == [line.text for line in played.lines][:5]
    assert jumped.lines[0].text == 'second 30 has come'


def test_the_chosen_topic_has_its_latest_message(recording: Recording) -> None:
    before, spike, after = moments(recording, 24.99, 25.0, 25.05, topic='/load')
    assert [each.message.data for each in (before, spike, after)] == [10.0, 90.0, 10.0]
    assert spike.message_time == START + 25 * SECOND
    [late] = moments(recording, 50.0, topic='/robot_description')
    assert 'two_arms' in late.message.data


def test_goals_are_read_from_the_topics_of_their_actions(recording: Recording) -> None:
    goals = {bytes.fromhex(goal.goal_id): goal for goal in recording.read_goals()}
    assert goals.keys() == GOALS.keys()
    for goal_id, (began, ended, last) in GOALS.items():
        goal = goals[goal_id]
        assert goal.began == pytest.approx(began, abs=1e-3)
        assert goal.ended == pytest.approx(ended)
        assert goal.status == {4: 'SUCCEEDED', 6: 'ABORTED'}[last]
        assert len(goal.ticks) == ended - began


def test_a_plot_reads_the_whole_recording_and_keeps_its_spikes(recording: Recording) -> None:
    async def read() -> RecordedPlot:
        changed = asyncio.Event()
        plot = RecordedPlot(recording, '/load', 'data', changed.set)
        async with asyncio.timeout(BROWSER):
            while plot.part < 1.0:
                changed.clear()
                await changed.wait()
        return plot

    plot = asyncio.run(read())
    assert plot.problem == ''
    assert (START / SECOND + 25, 90.0) in plot.points
    assert plot.points[0][0] == START / SECOND


def test_an_outline_has_a_bound_whatever_it_is_told() -> None:
    outline = Outline(0.0, 1000.0)
    for number in range(200_000):
        outline.add(number / 200, math.nan if number == 5 else float(number == 77_777))
    points = outline.points()
    assert outline.count == 200_000
    assert len(points) <= 2 * SPANS
    assert (77_777 / 200, 1.0) in points


def test_a_path_names_a_number_as_the_tree_does() -> None:
    from geometry_msgs.msg import PoseWithCovariance

    message = PoseWithCovariance()
    message.pose.position.y = 2.5
    message.covariance[7] = 3.0
    assert number_at('pose.position.y')(message) == 2.5
    assert number_at('covariance[7]')(message) == 3.0
    assert number_at('covariance[99]')(message) is None
    assert number_at('pose.nothing')(message) is None


@pytest.fixture
def clock() -> list[float]:
    return [100.0]


def test_the_playhead_runs_at_its_rate_and_stops_at_the_end(clock: list[float]) -> None:
    head = Playhead(0, 10 * SECOND, lambda: clock[0])
    head.play()
    clock[0] += 2.0
    assert head.time == 2 * SECOND
    head.set_rate(0.5)
    clock[0] += 2.0
    assert head.time == 3 * SECOND
    head.step(-SECOND)
    clock[0] += 5.0
    assert (head.time, head.is_playing) == (2 * SECOND, False)
    head.play()
    clock[0] += 100.0
    assert (head.time, head.is_playing) == (10 * SECOND, False)
    head.play()
    assert (head.time, head.is_playing) == (0, True)
    head.seek(-5)
    assert head.time == 0


def test_a_topic_of_an_unknown_type_is_told_of_and_the_rest_is_shown(tmp_path: Path) -> None:
    with Writer(tmp_path / 'odd') as bag:
        bag.add_topic('/odd', 'nowhere_msgs/msg/Odd')
        bag.add_topic('/tf', 'tf2_msgs/msg/TFMessage')
        bag.write('/odd', b'\0\1\0\0', START)
        bag.write('/tf', b'\0\1\0\0', START + 1)  # cut off
    [moment] = moments(Recording(str(tmp_path / 'odd')), 0.1, topic='/odd')
    assert moment.message is None
    text = ' '.join(moment.problems)
    assert 'nowhere_msgs' in text
    assert "'/tf' is not shown" in text


def test_an_empty_bag_is_refused(tmp_path: Path) -> None:
    Writer(tmp_path / 'empty').close()
    with pytest.raises(BagError, match='no messages'):
        Recording(str(tmp_path / 'empty'))


@pytest.mark.slow
def test_a_jump_reads_a_part_of_the_bag_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The index says where to read: of the chunks of 200,000 messages a few are unpacked."""
    from goalwire.rosbag2 import mcap_reader

    recording = Recording(str(write_bag(tmp_path / 'long', 200_000)))
    with mcap_reader.McapReader(str(tmp_path / 'long' / 'long_0.mcap')) as file:
        recording_spans = list(file._spans)
    assert len(recording_spans) > 6
    taken: list[Any] = []
    decoded = mcap_reader.McapReader._messages_of

    def count(file: mcap_reader.McapReader, span: mcap_reader.Span) -> Any:
        taken.append(span)
        return decoded(file, span)

    monkeypatch.setattr(mcap_reader.McapReader, '_messages_of', count)
    moments(recording, 150.0, topic='/numbers')
    assert taken
    assert len({span.offset for span in taken}) < len(recording_spans) / 2

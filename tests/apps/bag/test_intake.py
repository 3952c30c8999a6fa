"""Between the wire and the file: bounds, counts, order, and a file that does not keep up."""

from __future__ import annotations

from threading import Event

from helpers.patience import PATIENCE, wait_for

from goalwire.apps.bag.intake import Intake
from goalwire.apps.bag.repeats import Repeats
from goalwire.errors import BagError
from goalwire.rosbag2.model import Message
from goalwire.transport.contract import Sample


class Held:
    """A sink that takes nothing before it may."""

    def __init__(self) -> None:
        self.may_go_on = Event()
        self.came: list[Message] = []
        self.flushes = 0
        self.syncs = 0

    def put(self, message: Message) -> None:
        assert self.may_go_on.wait(PATIENCE)
        self.came.append(message)

    def flush(self) -> None:
        self.flushes += 1

    def sync(self) -> None:
        self.syncs += 1


def sample(sequence: int, gid: bytes = b'a' * 16, size: int = 10) -> Sample:
    return Sample(bytes(size), sequence, 5, 6, gid)


def test_what_finds_no_room_is_dropped_and_counted() -> None:
    sink = Held()
    intake = Intake(sink, 100, Repeats({}), failed=lambda _: None)
    for sequence in range(1, 31):
        intake.put('/a' if sequence % 2 else '/b', sample(sequence), sequence)
    assert intake.losses.dropped == {'/a': 10, '/b': 10}
    assert intake.count == 10
    sink.may_go_on.set()
    intake.close()
    assert [message.sequence for message in sink.came] == list(range(1, 11))
    assert intake.losses.missed.total() == 0
    assert sink.flushes == sink.syncs == 1


def test_a_message_larger_than_all_room_is_taken_alone() -> None:
    sink = Held()
    sink.may_go_on.set()
    intake = Intake(sink, 100, Repeats({}), failed=lambda _: None)
    intake.put('/a', sample(1, size=1000), 1)
    intake.close()
    assert [len(message.data) for message in sink.came] == [1000]


def test_room_is_given_back() -> None:
    sink = Held()
    sink.may_go_on.set()
    intake = Intake(sink, 100, Repeats({}), failed=lambda _: None)
    for sequence in range(1, 200):
        intake.put('/a', sample(sequence), sequence)
        wait_for(lambda sequence=sequence: len(sink.came) == sequence)  # type: ignore[misc]
    intake.close()
    assert not intake.losses.dropped.total()


def test_gaps_in_a_publishers_numbers_are_counted() -> None:
    sink = Held()
    sink.may_go_on.set()
    intake = Intake(sink, 10_000, Repeats({}), failed=lambda _: None)
    for sequence in (7, 8, 11, 9, 12):  # 9 came late, and 10 never did
        intake.put('/a', sample(sequence), 1)
    for sequence in (1, 4):
        intake.put('/a', sample(sequence, b'b' * 16), 1)
    intake.put('/dds', sample(0), 1)
    intake.put('/dds', sample(0), 1)
    intake.close()
    assert intake.losses.missed == {'/a': 1 + 2}


def test_jobs_run_between_the_messages_around_them() -> None:
    sink = Held()
    intake = Intake(sink, 10_000, Repeats({}), failed=lambda _: None)
    seen: list[int] = []
    for sequence in range(1, 6):
        intake.put('/a', sample(sequence), sequence)
        intake.run(lambda: seen.append(len(sink.came)))
    sink.may_go_on.set()
    intake.close()
    assert seen == [1, 2, 3, 4, 5]


def test_a_sink_that_fails_is_told_once_and_ends_the_taking() -> None:
    class Broken(Held):
        def put(self, message: Message) -> None:
            super().put(message)
            raise BagError('no')

    sink = Broken()
    told: list[BagError] = []
    sink.may_go_on.set()
    intake = Intake(sink, 10_000, Repeats({}), failed=told.append)
    intake.put('/a', sample(1), 1)
    wait_for(lambda: told)
    intake.put('/a', sample(2), 1)
    intake.close()
    assert [str(error) for error in told] == ['no']
    assert intake.losses.dropped['/a'] == 2


def test_a_flush_comes_in_its_time_without_further_messages() -> None:
    sink = Held()
    sink.may_go_on.set()
    intake = Intake(sink, 10_000, Repeats({}), failed=lambda _: None)
    intake.put('/a', sample(1), 1)
    wait_for(lambda: sink.flushes == 1)
    wait_for(lambda: sink.syncs == 1)
    intake.close()
    assert sink.flushes == 1


def test_the_latest_of_each_publisher_are_repeated() -> None:
    repeats = Repeats({'/latched': 2})
    for time in range(5):
        repeats.note(Message('/latched', time, b'%d' % time, time), b'a')
        repeats.note(Message('/tf_static', time, b't%d' % time, time), b'a')
        repeats.note(Message('/other', time, b'o', time), b'a')
    repeats.note(Message('/tf_static', 9, b'of b', 9), b'b')
    heads = repeats.heads(77)
    assert [(head.topic, head.data, head.time) for head in heads] == [
        ('/latched', b'3', 77),
        ('/latched', b'4', 77),
        ('/tf_static', b't4', 77),
        ('/tf_static', b'of b', 77),
    ]

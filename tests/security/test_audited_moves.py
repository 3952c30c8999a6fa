"""Streams of commands in the audit log: few entries, and none of the messages uncounted."""

from __future__ import annotations

from goalwire.security.audited_moves import EACH_S, SILENT_S, Entry, Streams

WHAT = ('moves', 'ann', 'publish', '/cmd_vel', 'a rule')


class Log:
    """The entries of streams, at times that a test sets."""

    def __init__(self) -> None:
        self.now = 0.0
        self.entries: list[Entry] = []
        self.streams = Streams(self.entries.append, lambda: self.now)

    def play(self, seconds: float, rate: float) -> int:
        """Send commands at a rate, in Hz, for some time; return their number."""
        count = int(seconds * rate)
        for _ in range(count):
            self.streams.note(*WHAT)
            self.now += 1 / rate
        return count

    def counts(self) -> list[tuple[str, str]]:
        """Return outcome and number of messages of each entry."""
        return [(each['outcome'], each.get('messages', '')) for each in self.entries]


def test_a_stream_has_an_entry_each_minute_and_none_of_its_messages_is_lost() -> None:
    log = Log()
    sent = log.play(3 * EACH_S + 1, 20)
    log.now += SILENT_S
    log.streams.look()
    outcomes = [outcome for outcome, _ in log.counts()]
    assert outcomes == ['moves'] * 4 + ['ended']
    assert 1 + sum(int(count or 0) for _, count in log.counts()) == sent


def test_a_stream_that_pauses_begins_anew() -> None:
    log = Log()
    log.play(1, 10)
    log.now += SILENT_S
    log.play(1, 10)
    assert log.counts() == [('moves', ''), ('ended', '9'), ('moves', '')]


def test_the_end_of_the_program_ends_all_streams() -> None:
    log = Log()
    log.play(1, 10)
    log.streams.note('moves', 'bob', 'publish', '/cmd_vel', 'a rule')
    log.streams.close()
    assert log.counts()[2:] == [('ended', '9'), ('ended', '0')]

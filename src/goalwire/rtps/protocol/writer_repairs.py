"""Acknowledgements of a writer's reliable readers, and repeats of samples that they lack.

The writer asks a reliable reader by HEARTBEAT. The reader answers by ACKNACK, and gets its missing samples at
once. A reader that has answered before is asked some time after a sample, so that a stream of samples needs
few answers; this time is longer for a reader on this host that has lacked nothing. A reader that has not
answered may not know this writer yet, and is asked with each sample. A silent reader is asked at growing
intervals, and only a writer with KEEP_ALL waits for it.
"""

from __future__ import annotations

from collections.abc import Callable

from goalwire.rtps.protocol.announcements import EndpointData
from goalwire.rtps.protocol.fragment_windows import WINDOW, FragmentWindows
from goalwire.rtps.protocol.messages import AckNack, Gap
from goalwire.rtps.protocol.primitives import INFINITE, NumberSet
from goalwire.rtps.protocol.qos import TRANSIENT_LOCAL, Qos
from goalwire.rtps.protocol.reader_proxy import HEARTBEAT_S, MOST_PATIENCE_S, ReaderProxy
from goalwire.rtps.protocol.wire import FOREVER, Timer
from goalwire.rtps.protocol.writer_output import WriterOutput

TOGETHER_S = 0.002
"""Readers to be asked within this time are asked together, because each round goes over all readers."""
ON_THE_WAY_S = 0.004
"""How long samples count as on their way to a reader that says it has none.

When a writer and a reader meet, the samples and the request for them are sent at the same moment and cross.
This time is shorter than the time between HEARTBEATs.
"""
RAREST_HEARTBEAT_S = 1.0
"""The longest interval at which a silent reader is asked."""


class Repairs:
    """Asks the reliable readers of one writer for acknowledgements, and repeats samples that they lack.

    Methods are called inside `Wire.run`.
    """

    def __init__(
        self,
        output: WriterOutput,
        windows: FragmentWindows,
        qos: Qos,
        on_acknowledged: Callable[[], None],
        on_answered: Callable[[EndpointData], None],
    ) -> None:
        """`on_acknowledged` is called when a reader has acknowledged samples, or has gone.

        `on_answered` is called at each reader's first answer, in order with users' callbacks.
        """
        self._output = output
        self._windows = windows
        self._is_local_history = qos.durability >= TRANSIENT_LOCAL
        self._lifespan = qos.lifespan
        self._on_acknowledged = on_acknowledged
        self._on_answered = on_answered
        self.acked = 0
        """All samples up to this one are acknowledged by all reliable readers."""
        self.timer: Timer | None = None
        """None: no reader must be asked."""

    def expect_answers(self, *, is_patient: bool = False) -> None:
        """Plan a HEARTBEAT to the reliable readers that have not acknowledged all samples by then.

        With `is_patient` readers that have lacked nothing are asked later.
        """
        output = self._output
        now = output.wire.clock()
        for proxy in output.reliable:
            if output.is_open(proxy):
                wait = proxy.longest_wait() if is_patient else proxy.interval
                proxy.due = min(proxy.due, now + wait)
        self.set_timer(now)

    def ask_now(self) -> None:
        """Ask the reliable readers that have not acknowledged all samples, since a caller waits for that."""
        if self.timer is not None:
            self.timer.cancel()
        now = self._output.wire.clock()
        for proxy in self._output.reliable:
            if proxy.has_answered:
                proxy.due = min(proxy.due, now)
        self._ask()

    def set_timer(self, now: float) -> None:
        """Set the timer to the time at which the next readers must be asked."""
        output = self._output
        due = min((proxy.due for proxy in output.reliable), default=FOREVER)
        if due <= now + MOST_PATIENCE_S:
            # A reader that gets its sample while the timer is set waits for the timer, so the timer must not
            # be later than the least patient reader allows.
            due = min(due, now + min(proxy.longest_wait() for proxy in output.reliable))
        if self.timer is not None:
            if self.timer.when <= due:
                return
            self.timer.cancel()
            self.timer = None
        if due < FOREVER:
            self.timer = output.wire.timers.at(max(due, now), self._ask)

    def _ask(self) -> None:
        """Send HEARTBEAT to the readers that are due to be asked."""
        output = self._output
        self.timer = None
        now = output.wire.clock()
        for proxy in output.reliable:
            self.take_received(proxy)
            if not output.is_open(proxy):
                proxy.due = FOREVER
            elif proxy.due <= now + TOGETHER_S:
                output.send_to(proxy, output.heartbeat(proxy))
                proxy.interval = min(2 * proxy.interval, RAREST_HEARTBEAT_S)
                proxy.due = now + proxy.interval
            elif proxy.due == FOREVER:
                proxy.due = now + proxy.longest_wait()
        self.set_timer(now)

    def on_acknack(self, proxy: ReaderProxy, acknack: AckNack) -> None:
        """Take an ACKNACK: note which samples the reader has, and send the missing ones.

        Called inside `Wire.run`.
        """
        output = self._output
        base, missing = acknack.missing.base, acknack.missing.numbers()
        has_nothing = base <= max(1, proxy.start) and not missing and not acknack.is_final
        if not proxy.is_reliable or not (has_nothing or acknack.counter != proxy.counter):
            return
        proxy.counter = acknack.counter
        if not proxy.has_answered:
            proxy.has_answered = True
            output.wire.tell(self._on_answered, proxy.data)
        last = output.last_for(proxy)
        self.note_received(proxy, min(base - 1, last))
        if missing:
            proxy.interval = proxy.patience = HEARTBEAT_S
            self.repair(proxy, missing)
        elif has_nothing and proxy.acked < last:
            # The reader has no sample yet, and would request all of them.
            if output.wire.clock() >= proxy.pushed_at + ON_THE_WAY_S:
                self.push(proxy, list(range(proxy.acked + 1, min(last, proxy.acked + 256) + 1)))
        elif not acknack.is_final:
            output.send_to(proxy, output.heartbeat(proxy))
        if output.is_open(proxy):
            self.expect_answers(is_patient=not (missing or has_nothing))

    def take_received(self, proxy: ReaderProxy) -> None:
        """Mark as acknowledged the samples that a reader has shown to have."""
        if proxy.received > proxy.acked:
            self.note_received(proxy, min(proxy.received, self._output.last_for(proxy)))

    def note_received(self, proxy: ReaderProxy, number: int) -> None:
        """Note that a reader has all samples up to `number`. Does nothing if that is known already."""
        before = proxy.acked
        if number <= before:
            return
        proxy.acked = number
        if proxy.addressed:
            self.forget_addressed(proxy, number)
        proxy.interval = HEARTBEAT_S
        proxy.patience = min(2 * proxy.patience, proxy.most_patience)
        proxy.due = FOREVER
        if before <= self.acked:  # otherwise another reader has fewer samples, and `self.acked` stays
            self.note_acked()
        else:
            self._on_acknowledged()

    def note_acked(self) -> None:
        """Drop the samples that all reliable readers have acknowledged."""
        output = self._output
        sent = output.find_last_sent()
        self.acked = min(
            (proxy.acked if output.is_open(proxy) else sent for proxy in output.reliable), default=sent
        )
        if self._is_local_history:
            output.history.forget_gone(self.acked)
        else:
            output.history.remove_up_to(self.acked)
        self._on_acknowledged()

    def forget_addressed(self, proxy: ReaderProxy, number: int) -> None:
        """Drop the samples up to `number` that are for only this reader."""
        history, addressed = self._output.history, proxy.addressed
        while addressed and addressed[0].number <= number:
            change = addressed.popleft()
            proxy.addressed_size -= change.size
            if not self._is_local_history:
                history.remove(change.number)

    def push(self, proxy: ReaderProxy, numbers: list[int]) -> None:
        """Send samples to a reader that has none, without waiting for its request."""
        proxy.pushed_at = self._output.wire.clock()
        self.repair(proxy, numbers)

    def repair(self, proxy: ReaderProxy, numbers: list[int]) -> None:
        """Send samples again to one reader, at most one window, and then ask which samples it lacks."""
        output = self._output
        if self._lifespan < INFINITE:
            output.history.expire(output.wire.wall_clock_ns() - self._lifespan)
        last = output.last_for(proxy)
        gone: list[int] = []
        parts: list[bytes] = []
        size, left = 0, WINDOW
        for number in numbers:
            change = output.history.changes.get(number)
            if number > last or left <= 0:
                break
            if change is not None and change.size > output.fragment_size and not change.fragment_size:
                # A sample that was written before the first reader came has not been cut into fragments yet.
                change.fragment_size = output.fragment_size
            if change is None or number < proxy.start or change.reader not in (None, proxy.data.guid):
                gone.append(number)
            elif change.fragment_size:
                self._windows.send_some(proxy, change, range(1, 257))
                left -= min(WINDOW, change.size)
            else:
                part = output.whole(proxy, change)
                if size + len(part) > output.fragment_size:
                    output.send_to(proxy, b''.join(parts))
                    parts, size = [], 0
                parts.append(part)
                size += len(part)
                left -= len(part)
        if gone:
            parts.insert(0, self._gap(proxy, gone))
        parts.append(output.heartbeat(proxy))
        output.send_to(proxy, b''.join(parts))

    def _gap(self, proxy: ReaderProxy, numbers: list[int]) -> bytes:
        """Return GAP for the samples with these sorted numbers, which are less than 256 apart."""
        base = numbers[0] + 1
        while base - numbers[0] < len(numbers) and numbers[base - numbers[0]] == base:
            base += 1
        rest = [number for number in numbers if number >= base]
        return Gap(proxy.entity_id, self._output.entity_id, numbers[0], NumberSet.of(base, rest)).encode()

    def stop(self) -> None:
        """Stop asking."""
        if self.timer is not None:
            self.timer.cancel()

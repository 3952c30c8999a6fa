"""Tasks that watch the frequency of events and the age of their stamps."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.time import Time

from diagnostic_updater._diagnostic_status_wrapper import DiagnosticStatusWrapper
from diagnostic_updater._diagnostic_updater import DiagnosticTask

__all__ = [
    'FrequencyStatus',
    'FrequencyStatusParam',
    'Heartbeat',
    'SlowTimeStampStatus',
    'TimeStampStatus',
    'TimeStampStatusParam',
]

NANOSECONDS = 1e-9


class FrequencyStatusParam:
    """The frequencies that a FrequencyStatus accepts, in Hz.

    `freq_bound` has the key 'min' and, if there is an upper bound, 'max'; the dict may be changed at any
    time. `tolerance` widens each bound by this share of it. The frequency is computed over `window_size`
    updates.
    """

    def __init__(self, freq_bound: Mapping[str, float], tolerance: float = 0.1, window_size: int = 5) -> None:
        self.freq_bound = freq_bound
        self.tolerance = tolerance
        self.window_size = window_size

    @property
    def lowest(self) -> float:
        """The lowest frequency that is accepted."""
        return self.freq_bound['min'] * (1 - self.tolerance)

    @property
    def highest(self) -> float:
        """The highest frequency that is accepted; infinite without an upper bound."""
        return self.freq_bound.get('max', math.inf) * (1 + self.tolerance)


class FrequencyStatus(DiagnosticTask):
    """Reports a warning if events come too seldom or too often, an error if none came in the window."""

    def __init__(self, params: FrequencyStatusParam, name: str = 'FrequencyStatus') -> None:
        super().__init__(name)
        self.params = params
        self.lock = threading.Lock()
        # By the steady clock the frequency stays right even if somebody sets the machine's clock.
        self._clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.clear()

    def clear(self) -> None:
        """Forget all events."""
        with self.lock:
            self.count = 0
            start = (self._clock.now(), 0)
            # One entry for each update of the window: its time, and the number of events until then.
            self._updates: deque[tuple[Time, int]] = deque([start] * self.params.window_size)

    def tick(self) -> None:
        """Count an event."""
        with self.lock:
            self.count += 1

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Fill the status from the events of the last `window_size` updates."""
        with self.lock:
            now, count = self._clock.now(), self.count
            then, count_then = self._updates.popleft()
            self._updates.append((now, count))
        events, window = count - count_then, (now - then).nanoseconds * NANOSECONDS
        # The window is 0 if virtual time stands still between two updates.
        frequency = events / window if window else (math.inf if events else 0.0)
        params, bound = self.params, self.params.freq_bound
        if events == 0:
            stat.summary(DiagnosticStatus.ERROR, 'No events recorded.')
        elif frequency < params.lowest:
            stat.summary(DiagnosticStatus.WARN, 'Frequency too low.')
        elif frequency > params.highest:
            stat.summary(DiagnosticStatus.WARN, 'Frequency too high.')
        else:
            stat.summary(DiagnosticStatus.OK, 'Desired frequency met')
        stat.add('Events in window', events)
        stat.add('Events since startup', count)
        stat.add('Duration of window (s)', f'{window:f}')
        stat.add('Actual frequency (Hz)', f'{frequency:f}')
        if bound.get('max') == bound['min']:
            stat.add('Target frequency (Hz)', f'{bound["min"]:f}')
        if bound['min'] > 0:
            stat.add('Minimum acceptable frequency (Hz)', f'{params.lowest:f}')
        if 'max' in bound:
            stat.add('Maximum acceptable frequency (Hz)', f'{params.highest:f}')
        return stat


class TimeStampStatusParam:
    """The ages, in s, of stamps that a TimeStampStatus accepts; a stamp in the future has a negative age."""

    def __init__(self, min_acceptable: float = -1, max_acceptable: float = 5) -> None:
        self.min_acceptable = min_acceptable
        self.max_acceptable = max_acceptable


class TimeStampStatus(DiagnosticTask):
    """Reports an error if a stamp since the last update was too old, in the future, or zero.

    The age of a stamp is measured by `clock`: pass the node's clock, since its time may be simulated. None
    stands for the system's clock. If no stamp came since the last update, the status is a warning; that of
    SlowTimeStampStatus is OK.
    """

    without_data = DiagnosticStatus.WARN

    def __init__(
        self,
        params: TimeStampStatusParam | None = None,
        name: str = 'Timestamp Status',
        *,
        clock: Clock | None = None,
    ) -> None:
        super().__init__(name)
        self.params = params or TimeStampStatusParam()
        self.lock = threading.Lock()
        self.early_count = 0
        self.late_count = 0
        self.zero_count = 0
        self._clock = clock or Clock(clock_type=ClockType.ROS_TIME)
        self._begin()

    def _begin(self) -> None:
        """Forget the stamps of the last update; keep the counts of updates with bad stamps."""
        self.zero_seen = False
        self.deltas_valid = False
        self.min_delta = 0.0
        self.max_delta = 0.0

    def tick(self, stamp: Time | float) -> None:
        """Take an event's stamp: a Time, or a number of seconds."""
        nanoseconds = stamp.nanoseconds if isinstance(stamp, Time) else round(stamp / NANOSECONDS)
        with self.lock:
            if nanoseconds == 0:
                self.zero_seen = True
                return
            age = (self._clock.now().nanoseconds - nanoseconds) * NANOSECONDS
            self.min_delta = min(self.min_delta, age) if self.deltas_valid else age
            self.max_delta = max(self.max_delta, age) if self.deltas_valid else age
            self.deltas_valid = True

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Fill the status from the stamps since the last update."""
        with self.lock:
            self._judge(stat)
            stat.add('Earliest timestamp delay:', f'{self.min_delta:f}')
            stat.add('Latest timestamp delay:', f'{self.max_delta:f}')
            stat.add('Earliest acceptable timestamp delay:', f'{self.params.min_acceptable:f}')
            stat.add('Latest acceptable timestamp delay:', f'{self.params.max_acceptable:f}')
            stat.add('Late diagnostic update count:', self.late_count)
            stat.add('Early diagnostic update count:', self.early_count)
            stat.add('Zero seen diagnostic update count:', self.zero_count)
            self._begin()
        return stat

    def _judge(self, stat: DiagnosticStatusWrapper) -> None:
        stat.summary(DiagnosticStatus.OK, 'Timestamps are reasonable.')
        if not self.deltas_valid:
            stat.summary(self.without_data, 'No data since last update.')
            return
        if self.min_delta < self.params.min_acceptable:
            stat.summary(DiagnosticStatus.ERROR, 'Timestamps too far in future seen.')
            self.early_count += 1
        if self.max_delta > self.params.max_acceptable:
            stat.summary(DiagnosticStatus.ERROR, 'Timestamps too far in past seen.')
            self.late_count += 1
        if self.zero_seen:
            stat.summary(DiagnosticStatus.ERROR, 'Zero timestamp seen.')
            self.zero_count += 1


class SlowTimeStampStatus(TimeStampStatus):
    """A TimeStampStatus for events rarer than updates: without new stamps it reports OK, as in C++."""

    without_data = DiagnosticStatus.OK


class Heartbeat(DiagnosticTask):
    """A task that reports OK at each update, which shows that the node is alive."""

    def __init__(self) -> None:
        super().__init__('Heartbeat')

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Report OK."""
        stat.summary(DiagnosticStatus.OK, 'Alive')
        return stat

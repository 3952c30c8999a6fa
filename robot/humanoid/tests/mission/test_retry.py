from __future__ import annotations

import pytest

from humanoid.mission.retry import Backoff, NoAnswer, retry


class Time:
    """A clock that only sleeping and attempts move."""

    def __init__(self) -> None:
        self.now = 0.0

    def sleep(self, seconds: float) -> None:
        self.now += seconds

    def __call__(self) -> float:
        return self.now


class Service:
    """Answers from a given attempt on; an attempt without an answer takes all of its time."""

    def __init__(self, time: Time, answers_from: int) -> None:
        self.allowed: list[float] = []
        self._time = time
        self._answers_from = answers_from

    def __call__(self, seconds: float) -> str:
        self.allowed.append(seconds)
        if len(self.allowed) < self._answers_from:
            self._time.sleep(seconds)
            raise NoAnswer('nobody')
        return 'here'


def run(service: Service, time: Time, timeout: float = 10.0) -> tuple[str, int, list[tuple[int, float]]]:
    told: list[tuple[int, float]] = []
    answer, attempts = retry(
        service,
        attempt_timeout=0.5,
        timeout=timeout,
        backoff=Backoff(first=0.2, factor=2.0, longest=1.0),
        on_retry=lambda attempt, pause, _why: told.append((attempt, pause)),
        sleep=time.sleep,
        clock=time,
    )
    return answer, attempts, told


def test_an_answer_at_once_needs_no_retry() -> None:
    time = Time()
    assert run(Service(time, 1), time) == ('here', 1, [])
    assert time.now == 0.0


def test_pauses_grow_up_to_their_limit() -> None:
    time = Time()
    answer, attempts, told = run(Service(time, 6), time)
    assert (answer, attempts) == ('here', 6)
    assert told == [(1, 0.2), (2, 0.4), (3, 0.8), (4, 1.0), (5, 1.0)]


def test_it_gives_up_before_the_deadline_and_says_how_often_it_tried() -> None:
    time = Time()
    with pytest.raises(NoAnswer, match=r'nobody \(attempt 3, none left within 2 s\)'):
        run(Service(time, 99), time, timeout=2.0)
    assert time.now <= 2.0


def test_the_last_attempt_gets_only_the_time_that_is_left() -> None:
    time = Time()
    service = Service(time, 99)
    with pytest.raises(NoAnswer):
        run(service, time, timeout=1.0)
    assert service.allowed == [0.5, pytest.approx(0.3)]


def test_any_other_exception_is_not_retried() -> None:
    def broken(_seconds: float) -> str:
        raise ValueError('no')

    with pytest.raises(ValueError, match='no'):
        retry(broken, attempt_timeout=1.0, timeout=9.0, backoff=Backoff(), on_retry=lambda *_: None)

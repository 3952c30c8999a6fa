"""A member's report: a line per event, written to standard output at once, so that kill -9 loses none."""

from __future__ import annotations

import asyncio
import os
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import count
from time import monotonic

from benchmarks.soak.work import ANSWERED, GIVEN_UP, UNEXPECTED, Work
from goalwire.errors import CallError
from goalwire.rules.statistics import NodeStatistics

NUMBERS = 10**9
"""A tag is a member's incarnation times this, plus a number."""


class WrongAnswer(Exception):
    """An answer that belongs to no such request."""


class Call:
    """One call under way: its `tag` goes with the request."""

    def __init__(self, tag: int) -> None:
        self.tag = tag
        self.handled_as = str(tag)
        """The server's name for it: the id if it is a goal."""


class Report:
    """The reports of one incarnation of a member."""

    def __init__(self, incarnation: int) -> None:
        self._base = incarnation * NUMBERS
        self._numbers = count(1)

    def new_tag(self) -> int:
        return self._base + next(self._numbers)

    def say(self, *words: object) -> None:
        os.write(1, ('\t'.join(map(str, words)) + '\n').encode())

    @contextmanager
    def call(self, work: Work, server: str) -> Iterator[Call]:
        """Report that a call is sent, and in the end what came of it and by how much it missed its deadline.

        Errors of calls end here; what else is raised is reported as unexpected.
        """
        call = Call(self.new_tag())
        self.say('sent', call.tag, server, work.title)
        begun, outcome, told = monotonic(), ANSWERED, ''
        try:
            yield call
        except CallError as error:
            outcome, told = type(error).__name__, str(error)
        except asyncio.CancelledError:
            outcome = GIVEN_UP
            raise
        except Exception:
            outcome = UNEXPECTED
            traceback.print_exc()
        finally:
            late_ms = max(0, round((monotonic() - begun - work.timeout) * 1000))
            self.say('ended', call.tag, late_ms, call.handled_as, outcome, told)

    def check_sum(self, work: Work, call: Call, got: int) -> None:
        """Raise WrongAnswer where a service has added wrongly."""
        if got != call.tag + work.ask:
            raise WrongAnswer(f'{got} for {call.tag} + {work.ask}')

    def check_goal(self, work: Work, result: Sequence[int], feedback: Sequence[int]) -> None:
        """Raise WrongAnswer for the wrong steps, or feedback out of order; count the feedback missed.

        Feedback has no place in the order of results: the last of it may come too late for its goal.
        """
        steps = list(range(work.ask))
        if list(result) != steps or list(feedback) != sorted(set(feedback)):
            raise WrongAnswer(f'{list(result)} after {list(feedback)} for {work.ask} steps')
        self.say('feedback', len(feedback), len(steps) - len(feedback))

    def check_empty(self, statistics: NodeStatistics) -> None:
        """Report what a node's clients still hold, now that all their calls have ended."""
        requests = sum(client.in_flight for client in statistics.clients)
        goals = sum(client.goals.unanswered for client in statistics.action_clients)
        results = sum(client.goals.waiting_for_results for client in statistics.action_clients)
        self.say('held', statistics.name, requests, goals, results)

    def handled(self, what: object) -> None:
        """A handler was entered for this tag or goal."""
        self.say('handled', what)


class Hearing:
    """Follows numbered messages: how many came, were missed, or came in the wrong order."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._latest: dict[int, int] = {}
        self._counts = [0, 0, 0]

    def hear(self, tag: int) -> None:
        publisher, number = divmod(tag, NUMBERS)
        before = self._latest.get(publisher, number - 1)
        self._counts[0] += 1
        self._counts[1] += max(0, number - before - 1)
        self._counts[2] += number <= before
        self._latest[publisher] = max(before, number)
        if self._counts[0] >= 100:
            self.tell()

    def tell(self) -> None:
        self._report.say('heard', *self._counts)
        self._counts = [0, 0, 0]

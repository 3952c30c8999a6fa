"""The books of a fleet under chaos: what was sent, how it ended, and what the robots have run."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

SUCCEEDED = 'SUCCEEDED'
CALLS = 'call'
NEVER_RUN = {'NO SERVER', 'NOT SENT', 'REFUSED', 'NoServerError', 'NoRobotError', 'GoalRefused'}
"""Ends that promise that the robot has not run the goal or the call."""


class Books:
    """Reads the files that the dispatcher and the robots write, once all have ended."""

    def __init__(self, folder: Path) -> None:
        """Read the files `told`, `executed` and `handled` in a folder."""
        self.problems: list[str] = []
        self.outcomes: Counter[tuple[str, str]] = Counter()
        """How many goals and calls of a kind have ended in a way."""
        self._runs = {
            name: Counter(_lines(folder / file)) for name, file in (('goal', 'executed'), (CALLS, 'handled'))
        }
        self._ends: dict[tuple[str, str], str] = {}
        """The end of each goal and each call, by its kind and id; '' until it has ended."""
        for line in _lines(folder / 'told'):
            what, kind, key, *outcome = line.split('\t')
            if what == 'sent':
                self._send(kind, key)
            else:
                self._end(kind, key, outcome[0])
        self._balance()

    def _send(self, kind: str, key: str) -> None:
        if (kind, key) in self._ends:
            self.problems.append(f'{kind} {key} was sent twice')
        self._ends[kind, key] = ''

    def _end(self, kind: str, key: str, outcome: str) -> None:
        if self._ends.get((kind, key)) != '':
            self.problems.append(f'{kind} {key} ended twice, or was never sent: {outcome}')
        self._ends[kind, key] = outcome
        self.outcomes[kind, outcome] += 1

    def _runs_of(self, kind: str, key: str) -> int:
        return self._runs[CALLS if kind == CALLS else 'goal'][key]

    def _balance(self) -> None:
        for (kind, key), outcome in self._ends.items():
            runs = self._runs_of(kind, key)
            if not outcome:
                self.problems.append(f'{kind} {key} never ended, and ran {runs} times')
            if runs > 1:
                self.problems.append(f'{kind} {key} ran {runs} times: {outcome}')
            if runs == 0 and outcome == SUCCEEDED:
                self.problems.append(f'{kind} {key} succeeded, and no robot has run it')
            if runs and outcome in NEVER_RUN:
                self.problems.append(f'{kind} {key} ran, though it ended as {outcome}')
        sent = {key for _, key in self._ends}
        for name, run in self._runs.items():
            for key in run.keys() - sent:
                self.problems.append(f'a robot has run {name} {key}, which nobody has sent')

    def table(self) -> str:
        """Return a table in Markdown with a row for each kind."""
        rows = [
            '| kind | sent | succeeded | failed, and did not run | failed, and ran | ends of the failed |',
            '|---|---|---|---|---|---|',
        ]
        for kind in sorted({kind for kind, _ in self._ends}):
            ends = {key: end for (of, key), end in self._ends.items() if of == kind}
            failed = {key: end for key, end in ends.items() if end != SUCCEEDED}
            ran = sum(self._runs_of(kind, key) > 0 for key in failed)
            told = ', '.join(f'{end} {number}' for end, number in Counter(failed.values()).most_common())
            rows.append(
                f'| {kind} | {len(ends)} | {len(ends) - len(failed)} | {len(failed) - ran} | {ran} | {told} |'
            )
        return '\n'.join(rows)


def _lines(path: Path) -> list[str]:
    return path.read_text(encoding='utf-8').splitlines() if path.exists() else []

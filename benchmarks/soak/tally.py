"""The books: every call that was sent, what came of it, and what is wrong with that."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from benchmarks.soak.work import ANSWERED, GRACE_S, is_expected

LATE_MS = GRACE_S * 1000 + 3000
"""How much later than its deadline a call may end: a goal's grace, and a machine that is busy."""
CUT_OFF = 'caller killed'


@dataclass
class Tally:
    """Fed with the members' lines; `problems` says what must not have happened."""

    may_close: bool
    """True where members leave their blocks instead of being killed."""
    sent: Counter[str] = field(default_factory=Counter)
    outcomes: Counter[tuple[str, str]] = field(default_factory=Counter)
    open: dict[int, tuple[str, str]] = field(default_factory=dict)
    """Server and title of each call under way, by tag."""
    handled: set[str] = field(default_factory=set)
    answered: set[str] = field(default_factory=set)
    """The answered ones: the servers must have handled these."""
    late_ms: int = 0
    heard: list[int] = field(default_factory=lambda: [0, 0, 0])
    """Messages that came, that were missed, and that came in the wrong order."""
    feedback: list[int] = field(default_factory=lambda: [0, 0])
    commanded: Counter[str] = field(default_factory=Counter)
    """The commands that servers have heard, by kind."""
    tried: Counter[str] = field(default_factory=Counter)
    """The commands that were tried after the end of a commander's context."""
    problems: list[str] = field(default_factory=list)

    def take(self, line: str) -> None:
        """Enter one line of a member."""
        what, *rest = line.split('\t')
        if what == 'sent':
            tag, server, title = rest
            self.sent[title] += 1
            self.open[int(tag)] = server, title
        elif what == 'ended':
            tag, late, handled_as, outcome, told = rest
            self._end(int(tag), int(late), handled_as, outcome, told)
        elif what == 'handled':
            if rest[0] in self.handled:
                self.problems.append(f'{rest[0]} was handled twice')
            self.handled.add(rest[0])
        elif what == 'heard':
            self.heard = [a + int(b) for a, b in zip(self.heard, rest, strict=True)]
        elif what == 'feedback':
            self.feedback = [a + int(b) for a, b in zip(self.feedback, rest, strict=True)]
        elif what == 'held':
            name, *held = rest
            if set(held) != {'0'}:
                self.problems.append(f'{name} ended with requests, goals, results under way: {held}')
        elif what == 'commanded':
            self.commanded[rest[0]] += int(rest[1])
        elif what == 'stopped':
            kind, tried, through = rest
            self.tried[kind] += int(tried)
            if through != '0':
                self.problems.append(f'{through} of {tried} commands ({kind}) went through after SIGTERM')
        elif what == 'late':
            self.problems.append('a server heard a {} ({}) that was sent after SIGTERM'.format(*rest))
        elif what not in {'ready', 'left', 'terminated'}:
            self.problems.append(f'a line that means nothing: {line!r}')

    def _end(self, tag: int, late_ms: int, handled_as: str, outcome: str, told: str) -> None:
        call = self.open.pop(tag, None)
        if call is None:
            self.problems.append(f'call {tag} ended twice, or was never sent: {outcome}')
            return
        server, title = call
        self.outcomes[title, outcome] += 1
        self.late_ms = max(self.late_ms, late_ms)
        if outcome == ANSWERED:
            self.answered.add(handled_as)
        if not is_expected(title, server, outcome, may_close=self.may_close):
            self.problems.append(f'call {tag}: {title} of the {server} server: {outcome} ({told})')
        if late_ms > LATE_MS:
            self.problems.append(f'call {tag}: {title} of the {server} server ended {late_ms} ms too late')

    def cut_off(self, incarnation: int, numbers: int) -> None:
        """A caller was killed: what it had under way has no other end."""
        for tag in [tag for tag in self.open if tag // numbers == incarnation]:
            _, title = self.open.pop(tag)
            self.outcomes[title, CUT_OFF] += 1

    def close(self) -> list[str]:
        """Return all that is wrong, now that every member has ended."""
        titles = sorted({title for _, title in self.open.values()})
        if self.open:
            self.problems.append(f'{len(self.open)} calls never ended: {", ".join(titles)}')
        if sum(self.sent.values()) != sum(self.outcomes.values()) + len(self.open):
            self.problems.append('sent is not answered + failed')
        if missing := self.answered - self.handled:
            self.problems.append(f'{len(missing)} answers to requests that no server has handled')
        if self.heard[2]:
            self.problems.append(f'{self.heard[2]} messages came twice or in the wrong order')
        if not all(self.tried[kind] and self.commanded[kind] for kind in ('message', 'call', 'goal')):
            self.problems.append(f'commands heard: {self.commanded}; tried after SIGTERM: {self.tried}')
        return self.problems

    def rows(self) -> list[tuple[str, int, int, dict[str, int]]]:
        """Return title, sent, answered and failures by type, for each kind of call and for all."""
        rows = []
        for title in sorted(self.sent):
            by_type = {kind: n for (of, kind), n in sorted(self.outcomes.items()) if of == title}
            rows.append((title, self.sent[title], by_type.pop(ANSWERED, 0), by_type))
        return rows

    @property
    def ended(self) -> tuple[int, int]:
        """How many calls were answered, and how many failed."""
        answered = sum(n for (_, kind), n in self.outcomes.items() if kind == ANSWERED)
        return answered, sum(self.outcomes.values()) - answered

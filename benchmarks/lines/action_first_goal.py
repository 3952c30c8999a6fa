"""The first goal that a client reaches, beside the tenth: what is made at first use must not delay it."""

from __future__ import annotations

from benchmarks import stage
from benchmarks.line import Figures, Goal, Line, Of
from benchmarks.lines.action_feedback import MESSAGES, answer, reaching

LINE = Line(
    f'the first goal of a client, {MESSAGES} feedback messages',
    __name__,
    10,
    ('first', 'tenth', 'first_to_tenth'),
    (Goal('first_to_tenth', Of.ONE, 1.25, None),),
    looks=False,
    spins=False,
)


def ask(count: int) -> Figures:
    with stage.Partner('benchmarks.lines.action_feedback'), reaching() as reach:
        first, *_, last = [reach().seconds * 1e3 for _ in range(max(count, 2))]
        return {'first': first, 'tenth': last, 'first_to_tenth': first / last}


if __name__ == '__main__':
    stage.run(ask, answer)

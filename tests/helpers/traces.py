"""Traces of one program under two implementations of rclpy, and what differs between them on purpose."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias


@dataclass(frozen=True)
class Outcome:
    """The value or the error of one call of a program: `raises` are class names, most derived first."""

    call: str
    gives: str = ''
    raises: tuple[str, ...] = ()
    text: str = ''
    printed: str = ''

    def __str__(self) -> str:
        what = f'{self.raises[0]}: {self.text}' if self.raises else self.gives
        return f'{what} (printed: {self.printed})' if self.printed else what

    def stands_for(self, real: Outcome, foreign_texts: Sequence[str] = ()) -> bool:
        """True if a program that knows the real outcome is content with this one.

        That is: the same value; the same exception or one derived from it, whose text may say more, and
        need not repeat the real one where that is among `foreign_texts` (patterns).
        """
        if not real.raises or not self.raises:
            return str(self) == str(real)
        same_text = real.text.strip() in self.text or any(
            re.search(text, real.text) for text in foreign_texts
        )
        return real.raises[0] in self.raises and same_text and self.printed == real.printed


Trace: TypeAlias = Callable[[str], tuple[list[Outcome], list[Outcome]]]
"""`trace(name)` runs a program of tests/conformance/programs/: goalwire's trace, and the real one's."""


def read_trace(lines: str) -> list[Outcome]:
    """Read what tests/conformance/tracer.py wrote."""
    told = map(json.loads, lines.splitlines())
    return [Outcome(**(line | {'raises': tuple(line.get('raises', ()))})) for line in told]


@dataclass(frozen=True)
class Difference:
    """Calls whose outcome differs on purpose, with ours; `docs` is a phrase of the page that argues."""

    docs: str
    calls: dict[str, str]
    program: str | None = None

    def concerns(self, program: str) -> bool:
        """True for a difference of this program, or of any."""
        return self.program in {None, program}


@dataclass(frozen=True)
class ForeignText:
    """Texts of the real rclpy's errors that goalwire has its own words for: a pattern, any program's."""

    docs: str
    rclpy: str


class Differences:
    """All that differs on purpose: tests/conformance/differences.toml."""

    def __init__(self, file: Path) -> None:
        content = tomllib.loads(file.read_text(encoding='utf-8'))
        self.listed = [Difference(**entry) for entry in content['difference']]
        self.foreign_texts = [ForeignText(**entry) for entry in content['foreign_text']]

    def complaints(self, program: str, ours: list[Outcome], real: list[Outcome]) -> Iterator[str]:
        """Yield what is wrong: differences that are not listed, and listed ones that are gone."""
        concerned = [difference.calls for difference in self.listed if difference.concerns(program)]
        listed = {call: gives for calls in concerned for call, gives in calls.items()}
        return complaints(ours, real, listed, [text.rclpy for text in self.foreign_texts])


def complaints(
    ours: list[Outcome], real: list[Outcome], listed: dict[str, str], foreign_texts: Sequence[str] = ()
) -> Iterator[str]:
    """Yield what is wrong with two traces; `listed` has our outcome for each call that is to differ."""
    calls = [outcome.call for outcome in real]
    if [outcome.call for outcome in ours] != calls:
        # A statement that fails is told, one that succeeds is not: the traces then have different lengths.
        yield from _unlike(ours, real)
        return
    met = set()
    for our, their in zip(ours, real, strict=True):
        if our.stands_for(their, foreign_texts):
            continue
        met.add(our.call)
        if listed.get(our.call) != str(our):
            also = f'\n  listed:   {listed[our.call]}' if our.call in listed else ''
            yield f'{our.call}\n  goalwire: {our}\n  rclpy:    {their}{also}'
    for call in sorted({*listed} & {*calls} - met):
        yield f'{call}\n  is listed as a difference, but both do the same'


def _unlike(ours: list[Outcome], real: list[Outcome]) -> Iterator[str]:
    theirs, ours_ = {outcome.call for outcome in real}, {outcome.call for outcome in ours}
    for name, trace, others in (('goalwire', ours, theirs), ('rclpy', real, ours_)):
        for outcome in trace:
            if outcome.call not in others:
                yield f'{outcome.call}\n  told under {name} alone: {outcome}'
    if theirs == ours_:
        yield f'the programs ended early: {len(ours)} calls under goalwire, {len(real)} under rclpy'

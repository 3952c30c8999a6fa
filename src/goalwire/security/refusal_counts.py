"""The refusals of a session, for /diagnostics: what was refused to whom, how often, by which rule."""

from __future__ import annotations

from collections import Counter
from threading import Lock
from time import monotonic
from typing import NamedTuple, Protocol

RECENT_S = 60.0
"""For how long, in s, after its latest refusal an identity's status is a warning."""
MOST_ACTS = 256
"""How many acts of one identity are counted apart: a peer could invent names."""
OTHERS = 'other acts'


class RefusedActs(NamedTuple):
    """The acts that were refused to one identity."""

    who: str
    counts: dict[str, int]
    """How often each act was refused; the acts are in the policy's words: "call /reset"."""
    reason: str
    """The rule that has decided the first refusal of the latest act."""
    age_s: float
    """Seconds since the latest refusal."""


class _Acts:
    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.reason = ''
        self.latest = 0.0


class Listener(Protocol):
    """An object that is called when there are refusals."""

    def tell(self) -> None:
        """Note that there are refusals. Must not block."""


class RefusalCounts:
    """Counts the refusals of one session. Any thread may use it."""

    def __init__(self, identity: str) -> None:
        self.identity = identity
        """The name of the identity that has refused."""
        self._acts: dict[str, _Acts] = {}
        self._listeners: list[Listener] = []
        self._lock = Lock()

    def note(self, who: str, act: str, reason: str) -> None:
        """Note the rule that refuses an act to an identity, without counting the refusal."""
        with self._lock:
            acts = self._acts.setdefault(who, _Acts())
            acts.reason, acts.latest = reason, monotonic()
            acts.counts.setdefault(self._limit(acts, act), 0)

    def count(self, who: str, act: str) -> None:
        """Count an act that was refused."""
        with self._lock:
            acts = self._acts.setdefault(who, _Acts())
            acts.counts[self._limit(acts, act)] += 1
            acts.latest = monotonic()

    @staticmethod
    def _limit(acts: _Acts, act: str) -> str:
        return act if act in acts.counts or len(acts.counts) < MOST_ACTS else OTHERS

    def report(self) -> list[RefusedActs]:
        """Return what was refused to each identity."""
        now = monotonic()
        with self._lock:
            # The refusal of a declaration is noted without a count: it is reported as one.
            return [
                RefusedActs(
                    who,
                    {act: max(count, 1) for act, count in acts.counts.items()},
                    acts.reason,
                    now - acts.latest,
                )
                for who, acts in sorted(self._acts.items())
            ]

    @property
    def listeners(self) -> tuple[Listener, ...]:
        """The listeners that `tell` calls."""
        with self._lock:
            return tuple(self._listeners)

    def listen(self, listener: Listener) -> None:
        """Have a listener called about once a second, from the first refusal on."""
        with self._lock:
            self._listeners.append(listener)

    def close(self) -> None:
        """Call no listener any more: the session ends."""
        with self._lock:
            self._listeners.clear()

    def tell(self) -> None:
        """Call the listeners, if anything was refused."""
        with self._lock:
            listeners = list(self._listeners) if self._acts else []
        for listener in listeners:
            listener.tell()

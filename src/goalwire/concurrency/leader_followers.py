"""Decides which thread waits for a session's messages: an idle thread of the program, or the session's own.

The pattern is Leader/Followers. An idle thread takes the lead if no thread has it, waits in the waitset and
delivers the messages that come. It leaves when there is work for it, and wakes another idle thread to lead.
If there is no idle thread, the session's own thread takes over after a short while, since the thread that has
left usually comes back soon. So a message wakes only the thread that wants it.

Before it sleeps, the leader may spin on the wire for a moment: a message that comes then needs no wake-up
(`Look`).
"""

from __future__ import annotations

import os
from _thread import allocate_lock
from collections.abc import Callable, Mapping, Sized
from contextlib import suppress
from functools import partial
from threading import Event, Lock, Thread, get_ident
from time import monotonic_ns, sleep
from typing import Protocol

from goalwire.concurrency.forks import reset_in_children
from goalwire.concurrency.threads import begin, join_begun
from goalwire.concurrency.wire_poller import Sleeper, WirePoller
from goalwire.errors import TransportError

AWAY_S = 0.05
"""How long, in s, nobody leads before the session's own thread takes the lead; it may be twice as long. Each
check costs this thread some 15 us; there are 20 checks a second while leaders come and go. Threads that wait
are not delayed: an idle thread takes the lead itself, and for external sleepers the own thread leads at once.
"""
LOOPS_IDLE_S = 1.0
"""The longest pause in s between the own thread's checks, if asyncio loops read the wire and nothing comes.
"""
CLOSING_S = 5.0
"""How long, in s, closing waits for the leader to finish a delivery."""
FOREVER = 2**63 - 1
"""A timeout of this many ns means no limit."""
LOOK_VARIABLE = 'GOALWIRE_LOOK_US'
"""The environment variable for the longest spin on the wire before a sleep, in µs; 0: no spin."""
DEFAULT_LOOK_US = 200
"""The default spin in µs: longer than another process needs to wake up and answer, so the answer comes in
time.
"""
LONGEST_LOOK_US = 1000
TRIED, KEPT, RAREST = 8, 64, 1024
"""Numbers of waits: those that try the other mode (spin or sleep); those that keep spinning once it pays; and
those, at most, before spinning is tried again. The last number doubles each time that spinning does not
pay."""
WORTH = 7 / 8
"""Spinning pays if messages then come in less than this part of the time that they take without it."""
_LEAD = 'lead'
_STANDBY = object()

let_others_run: Callable[[], object] = getattr(os, 'sched_yield', partial(sleep, 0))


def look_ns(env: Mapping[str, str] = os.environ) -> int:
    """Return how long to spin before a sleep, in ns. Raises TransportError for an invalid setting."""
    text = env.get(LOOK_VARIABLE) or str(DEFAULT_LOOK_US)
    if not (text.isascii() and text.isdigit() and int(text) <= LONGEST_LOOK_US):
        raise TransportError(
            f"{LOOK_VARIABLE} is '{text}'; set it to microseconds from 0 (do not look) to {LONGEST_LOOK_US}"
        )
    return int(text) * 1000


class Look:
    """Waits on the wire; spins for a moment before it sleeps, as long as measurements show that it pays.

    A wake-up on another processor takes 35 to 100 µs. Spinning saves it if the message comes within that
    moment. Otherwise, or if other processes need the processor, spinning only costs. So the median time until
    a message comes is measured with spinning and without. The quicker mode is used for the next waits; then
    the other mode is tried for a few. If spinning does not pay, it is tried ever more rarely.
    """

    __slots__ = ('_before', '_left', '_longest_ns', '_looks', '_pause', '_times', '_tries', '_wait')

    def __init__(self, wait: Callable[[int], int], longest_ns: int) -> None:
        """`wait` is the wire's: it takes a timeout in ns and returns the number of ready events."""
        self._wait = wait
        self._longest_ns = longest_ns
        self._looks = self._tries = False
        self._pause = self._left = TRIED
        self._times: list[int] = []
        self._before = 0

    def __call__(self, timeout_ns: int) -> int:
        """Wait as `wait` does, and return its result."""
        begun = monotonic_ns()
        found = 0
        if self._looks:
            longest, wait = self._longest_ns, self._wait
            found = wait(0)
            while not found and monotonic_ns() - begun < longest:
                let_others_run()
                found = wait(0)
        if not found:
            found = self._wait(timeout_ns)
        if found > 0:
            self._left -= 1
            if self._left < TRIED:
                self._times.append(monotonic_ns() - begun)
                if not self._left:
                    self._decide()
        return found

    def _decide(self) -> None:
        """Choose between spinning and sleeping for the next waits, from the times of the last ones."""
        median = sorted(self._times)[TRIED // 2]
        self._times.clear()
        if not self._tries:  # the period is over: try the other mode
            self._tries, self._before, self._left = True, median, TRIED
            self._looks = not self._looks
            return
        looking, sleeping = (median, self._before) if self._looks else (self._before, median)
        self._tries = False
        self._looks = looking < WORTH * sleeping
        self._pause = TRIED if self._looks else min(2 * self._pause, RAREST)
        self._left = KEPT if self._looks else self._pause


class WireSet(Protocol):
    """The sockets, timers and calls of a wire. One thread at a time waits in it."""

    @property
    def awaited(self) -> Sized:
        """The requests that wait for an answer: not empty if an answer is likely to come soon."""

    def wait(self, timeout_ns: int, /) -> int:
        """Wait up to `timeout_ns`; return the number of ready events, negative once the wire is closed."""

    def descriptor(self) -> int | None:
        """Return a descriptor that is readable if `wait` would find an event; None if there is none."""

    def next_due(self) -> float:
        """Return when the next timer is due, on the monotonic clock; `wait` returns no later than that."""

    def serve(self, found: int) -> None:
        """Deliver the events that the last `wait` has found."""

    def interrupt(self) -> None:
        """End the current `wait`, or the next one if no thread waits. Any thread may call this."""


class LeaderFollowers(WirePoller):
    """One session's wire, and the threads that wait on it.

    The leader stands in the dict `_leader`, under _LEAD. A thread takes the lead by `setdefault`, which is
    one step: a signal's handler may raise before or after it, but not within it. So no thread that has left
    stays entered as the leader.
    """

    def __init__(self, wire: WireSet, name: str) -> None:
        """`name` is the name of the session's own thread, which `start` starts."""
        self.external_sleepers = set()
        self._name = name
        self._set = wire
        self._interrupt = wire.interrupt
        longest = look_ns()
        self._look_for_answers = Look(wire.wait, longest)
        self._look_for_more = Look(wire.wait, longest)
        self._least_ns = longest or FOREVER
        self._awaited = wire.awaited
        self._was_busy = False
        """True if the last wait has found an event."""
        self._loops: list[int] = []
        """The threads whose asyncio loops read the wire; a thread with two loops stands here twice."""
        self._period_s = AWAY_S
        """The time in s after which `_thread` checks again that the asyncio loops still read the wire."""
        self._leader: dict[str, object] = {}
        self._leaders_thread = 0
        self._followers: list[Sleeper] = []
        self._leaves = 0
        self._closed = False
        self._deserted = Event()
        self._starting = Lock()
        self._thread: Thread | None = None
        self._gate = allocate_lock()
        self._gate.acquire()
        self._dozing = False
        reset_in_children(self)

    def start(self) -> None:
        """Start the session's own thread, if it does not run."""
        with self._starting:
            if self._thread is None and not self._closed:
                self._thread = Thread(target=self._stand_by, name=self._name, daemon=True)
                begin(self._thread)

    def leads(self) -> bool:
        """True if the calling thread is the leader, which waits on the wire and delivers."""
        return _LEAD in self._leader and self._leaders_thread == get_ident()

    # -- idle threads

    def wait(self, sleeper: Sleeper, timeout_ns: int | None) -> bool:
        if self._closed or self.external_sleepers or (self._loops and get_ident() not in self._loops):
            return sleeper.wait_on_lock(timeout_ns)
        leader = self._leader
        try:
            if leader.setdefault(_LEAD, sleeper) is sleeper:
                return self._lead(sleeper, timeout_ns)
        finally:
            # No function is called before the lead is free: Python runs signal handlers after calls, and they
            # may raise.
            try:
                leads = _LEAD in leader and leader[_LEAD] is sleeper
            except KeyError:  # without a GIL, the leader has left in between
                leads = False
            if leads:
                sleeper.interrupt = None
                self._leaves += 1
                del leader[_LEAD]
                if self._dozing or self.external_sleepers:
                    self._dozing = False
                    self.ensure_polled()
                if self._followers or self._closed:
                    self._hand_over()
        return self._follow(sleeper, timeout_ns)

    def ensure_polled(self) -> None:
        with suppress(RuntimeError):  # the leader is awake already
            self._gate.release()

    def interrupt(self) -> None:
        self._set.interrupt()

    def _lead(self, sleeper: Sleeper, timeout_ns: int | None) -> bool:
        """Deliver incoming events until `sleeper` is woken (True) or its time has passed (False)."""
        self._leaders_thread = get_ident()
        deadline = None if timeout_ns is None else monotonic_ns() + timeout_ns
        left = FOREVER
        while True:
            sleeper.interrupt = self._interrupt
            if sleeper.take_wake():
                return True
            if deadline is not None:
                left = deadline - monotonic_ns()
                if left <= 0:
                    return False
            if self._loops and self._leaders_thread not in self._loops:
                return True  # a false alarm: the caller waits again, and sleeps on its lock
            if left > self._least_ns and (self._awaited or self._was_busy):
                look = self._look_for_answers if self._awaited else self._look_for_more
                found = look(left)
            else:
                found = self._set.wait(left)
            self._was_busy = found > 0
            sleeper.interrupt = None  # if this thread delivers what it awaits, it needs no wake-up
            if found < 0 or self._closed:
                return True
            if found:
                self._set.serve(found)

    def _follow(self, sleeper: Sleeper, timeout_ns: int | None) -> bool:
        """Sleep on the lock until `sleeper` is woken, because of an event or to lead."""
        followers, leader = self._followers, self._leader
        try:
            followers.append(sleeper)
            if leader.get(_LEAD) is _STANDBY:
                # the session's own thread leads: it leaves, and wakes this thread to lead
                self._set.interrupt()
            elif _LEAD not in leader:
                return True
            return sleeper.wait_on_lock(timeout_ns)
        finally:
            try:  # noqa: SIM105 - no call before the remove: a signal's handler may raise after calls
                followers.remove(sleeper)
            except ValueError:
                pass  # who hands over has taken it out

    def _hand_over(self) -> None:
        """Wake the latest follower, which then leads, and the thread that waits in `close`."""
        if self._closed:
            self._deserted.set()
        try:
            follower = self._followers.pop()
        except IndexError:
            return
        follower.wake()

    # -- asyncio loops

    def attach_loop(self) -> int | None:
        fd = None if self._closed else self._set.descriptor()
        if fd is None:
            return None
        own = os.dup(fd)  # the copy stays valid in the loop's selector when the session closes
        self._loops.append(get_ident())
        self._set.interrupt()  # the leading thread leaves the wire to the loop
        self.ensure_polled()
        return own

    def detach_loop(self, thread: int) -> None:
        self._loops.remove(thread)
        self.ensure_polled()

    def serve_ready(self) -> float:
        leader, me = self._leader, object()
        try:
            if leader.setdefault(_LEAD, me) is me:
                self._leaders_thread = get_ident()
                found = self._set.wait(0)
                if found > 0:
                    self._set.serve(found)
        finally:
            # No function is called before the lead is free; see `wait`.
            try:
                leads = _LEAD in leader and leader[_LEAD] is me
            except KeyError:
                leads = False
            if leads:
                self._leaves += 1
                del leader[_LEAD]
                if self._followers or self._closed:
                    self._hand_over()
        return self._set.next_due()

    def _read_for_loops(self) -> None:
        """Deliver the events that the asyncio loops have not read: a loop may be busy for long."""
        found = self._set.wait(0)
        if found > 0:
            self._set.serve(found)
            self._period_s = AWAY_S
        else:
            self._period_s = min(2 * self._period_s, LOOPS_IDLE_S)

    # -- the session's own thread

    def _stand_by(self) -> None:
        leader, followers = self._leader, self._followers
        while not self._closed:
            if leader.setdefault(_LEAD, _STANDBY) is _STANDBY:
                self._leaders_thread = get_ident()
                if self._loops and not self.external_sleepers:
                    self._read_for_loops()
                else:
                    while not (followers or self._closed) and (found := self._set.wait(FOREVER)) >= 0:
                        self._set.serve(found)
                        if self._loops and not self.external_sleepers:
                            break
                del leader[_LEAD]
                self._hand_over()
            self._standby()

    def _standby(self) -> None:
        """Sleep until no thread has led for a while."""
        gate, leader, leaves = self._gate, self._leader, -1
        while not self._closed:
            if self._loops and not self.external_sleepers:
                leaves = self._leaves
                gate.acquire(timeout=self._period_s)
                if self._loops and leaves == self._leaves and _LEAD not in leader:
                    return
                self._period_s = AWAY_S
                continue
            if self.external_sleepers or leaves == self._leaves:
                if _LEAD not in leader:
                    return
                # The leader waits for long. This thread sets `_dozing` first and then looks for a leader; a
                # leader gives up the lead first and then looks at `_dozing`. So one of them always notices
                # the other.
                self._dozing = True
                if _LEAD in leader:
                    gate.acquire()
                self._dozing = False
                leaves = -1
                continue
            leaves = self._leaves
            gate.acquire(timeout=AWAY_S)

    def close(self) -> None:
        """Have all threads leave the wire, and wait until they have left."""
        with self._starting:
            self._closed = True
            thread = self._thread
        self._set.interrupt()
        self.ensure_polled()
        if thread is not None:
            join_begun(thread, CLOSING_S)
        if _LEAD in self._leader and self._leaders_thread != get_ident():
            self._deserted.wait(CLOSING_S)

    def reset_in_child(self) -> None:
        """In a forked child, forget the waiting threads; nothing comes to this session any more."""
        self._closed = True

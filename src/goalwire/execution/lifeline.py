"""The life of a context: everything that waits is woken when it ends."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol
from weakref import ReferenceType, ref

from goalwire.execution.steady import STEADY, SteadyClock
from goalwire.execution.waiting import Keeper, Waiter

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.transport.contract import Session, Vigil


class Watch:
    """Somebody who wants to know when a lifeline ends."""

    __slots__ = ('_lifeline', '_wake')

    def __init__(self, lifeline: Lifeline, wake: Callable[[], None]) -> None:
        self._lifeline = lifeline
        self._wake = wake

    def close(self) -> None:
        """Watch no more."""
        self._lifeline._watchers.pop(self, None)  # noqa: SLF001

    def notify(self) -> None:
        """Pass the end on."""
        self._wake()


class Lifeline:
    """Ends once, for whatever reason. `clock` is the time that everything under this context lives in."""

    __slots__ = (
        '__weakref__',
        '_keepers',
        '_session',
        '_watchers',
        'alive',
        'clock',
        'dependants',
        'idle_waiters',
        'reason',
        'vigil',
    )

    def __init__(self, clock: SteadyClock = STEADY) -> None:
        self.clock = clock
        self.alive = True
        self.reason: str | None = None
        self.vigil: Vigil | None = None
        """Where threads under this may wait on the wire, once there is a session that lets them."""
        self.idle_waiters: list[Waiter] = []
        """As many as have blocked at the same time; see `borrow_waiter`."""
        self.dependants: set[object] = set()
        """Who sleeps under this where the wire does not reach it: asyncio loops, watchers of descriptors."""
        self._watchers: dict[Watch, None] = {}
        self._keepers: dict[ReferenceType[Keeper], None] = {}
        self._session: Session | None = None

    def take_session(self, session: Session) -> None:
        """Let threads under this wait on a session's wire, as far as it has a place for that.

        When this ends, nothing more is sent by that session.
        """
        vigil = session.vigil
        if vigil is not None:
            vigil.dependants = self.dependants
            self.vigil = vigil
        self._session = session  # then look: who ends this looks here after that
        if not self.alive:
            session.silence()

    def depend(self, who: object) -> None:
        """Have the session's own thread wait on the wire until `depend_no_more`. Any thread."""
        self.dependants.add(who)
        if self.vigil is not None:
            self.vigil.attend()

    def depend_no_more(self, who: object) -> None:
        """Undo `depend`; nothing where it was not called."""
        self.dependants.discard(who)

    def new_waiter(self) -> Waiter:
        """A place for one thread to sleep in while it waits for what the wire may bring; the end wakes it."""
        return Keeper(self)

    def borrow_waiter(self) -> Waiter:
        """The same for a short while: it goes back to `idle_waiters`. To make one takes five calls.

        Who had it before may still wake it: look again at what you wait for, as after every wake-up.
        """
        try:
            return self.idle_waiters.pop()
        except IndexError:
            return Keeper(self)

    def wake_at_end(self, keeper: Keeper) -> None:
        """Wake `keeper`, held weakly, when this ends: for all its life, where a watch is for one sleep."""
        self._keepers[ref(keeper, self._forget)] = None

    def _forget(self, reference: ReferenceType[Keeper]) -> None:
        self._keepers.pop(reference, None)

    def end(self, reason: str) -> bool:
        """End it and tell everybody; False if it has ended before. Takes no lock: signal handlers call it."""
        if not self.alive:
            return False
        self.reason = reason
        self._silence()  # first: who sees that this has ended relies on it
        self.alive = False
        self._silence()  # of a session that was taken in between
        self._session = None
        self._tell()
        return True

    def watch(self, wake: Callable[[], None]) -> Watch:
        """Call `wake` once when this ends; at once if it has ended.

        It may run on any thread and inside a signal handler: it must only wake somebody, and take no lock.
        """
        watch = Watch(self, wake)
        self._watchers[watch] = None
        if not self.alive:
            self._tell()
        return watch

    def _silence(self) -> None:
        session = self._session
        if session is not None:
            session.silence()

    def _tell(self) -> None:
        while self._watchers:
            try:
                watch, _ = self._watchers.popitem()
            except KeyError:
                break
            watch.notify()
        # Python 3.11 may collect garbage while it makes a tuple of this, which then changes: so a list.
        for reference in list(self._keepers):
            keeper = reference()
            if keeper is not None:
                keeper.wake()


class ContextLike(Protocol):
    """What execution needs of a context."""

    @property
    def lifeline(self) -> Lifeline:
        """Its life."""

    def ok(self) -> bool:
        """Whether it is initialised and not shut down."""


_provider: list[Callable[[], ContextLike]] = []


def provide_default_context(provider: Callable[[], ContextLike]) -> None:
    """Say where `default_context` finds the default context; the front does, once."""
    _provider[:] = [provider]


def default_context() -> ContextLike:
    """The context for what was made without one. Raises RuntimeError where no front was imported."""
    if not _provider:
        raise RuntimeError('there is no default context: pass context=..., or import rclpy first')
    return _provider[0]()

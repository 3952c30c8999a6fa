"""The life of sessions, nodes and endpoints, the same on all wires: open, then closed once.

An `EndpointState` keeps in `undo` the steps that take a session, node or endpoint off the wire. They run when
it is closed, the last one first; also if opening fails halfway. A session's nodes and a node's endpoints are
`Children`, and are closed with their parent. A `ForkGuard` tells if a session may not be used any more, since
this process is a forked child of the one that opened it, or the context has ended. `Shared` holds things that
several sessions use, as long as one of them does.

A fork copies a session's memory but not its threads and links. Whatever was opened before the fork raises
ForkedError in the child; what the child opens itself works.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from functools import partial
from threading import Lock, RLock
from typing import Generic, Protocol, TypeVar

from goalwire.concurrency.exits import Stage, at_exit, perform
from goalwire.concurrency.forks import ForkGuard, in_child, leak
from goalwire.errors import ClosedError, LocalError
from goalwire.fault_reports import LOGGER
from goalwire.transport.contract import NodePort, Port, Session
from goalwire.weak_members import WeakMembers

OTHER_CLOSER_S = 15.0
"""How long a second caller of `close` waits for the first; a silent peer can delay the first by 10 s."""

# -- one session, node or endpoint ---------------------------------------------------------------------------


class EndpointState:
    """The state of a session, node or endpoint: open or closed, and the steps that take it off the wire."""

    __slots__ = ('_turn', 'closed', 'guard', 'logger', 'title', 'undo')

    def __init__(self, title: str, guard: ForkGuard, logger: str = LOGGER) -> None:
        self.title = title
        self.logger = logger
        """The name of the logger for errors of this session, node or endpoint."""
        self.closed = False
        self.guard = guard
        """Shared by everything in a session. Each publish reads it directly, which saves the call of
        `is_forked`."""
        self.undo: list[Callable[[], object]] = []
        """The steps of closing, the last one first. If one fails, the others are done all the same."""
        self._turn = RLock()

    @property
    def is_forked(self) -> bool:
        """True in a child process that was forked after the session was opened."""
        return self.guard.is_forked

    def check(self) -> None:
        """Raise ClosedError after `close`, and ForkedError in a child that was forked after the opening."""
        if self.guard.is_forked:
            self.guard.check(self.title)
        if self.closed:
            raise ClosedError(
                f'{self.title} was used after it, its node or its context had been closed; '
                f'declare it again, or stop using it first'
            )

    def check_sending(self) -> None:
        """Raise ClosedError or ForkedError if a publisher or a client must not send."""
        self.check()
        if self.guard.is_silent:
            raise ClosedError(f'{self.title} was used after the end of its context; stop using it first')

    def close(self) -> None:
        """Run the steps in `undo`, once; a forked child has nothing to undo.

        A second caller waits for the first, so that everything is closed for it, too. A call from within one
        of the steps returns at once. Raises the error of the first step that failed.
        """
        if self.guard.is_forked or not self._turn.acquire(timeout=OTHER_CLOSER_S):
            return
        try:
            if not self.closed:
                self.closed = True
                self._undo_all()
        finally:
            self._turn.release()

    def _undo_all(self) -> None:
        failure: BaseException | None = None
        while self.undo:
            try:
                self.undo.pop()()
            except BaseException as error:
                failure = failure or error
        if failure is not None:
            raise failure


def answered_before(state: EndpointState) -> LocalError:
    """Return the error of a server's second reply to one request."""
    return LocalError(f'{state.title}: this request was answered before; answer it once')


class Child(Protocol):
    """Something that was declared through a session or node."""

    gid: bytes
    state: EndpointState


C = TypeVar('C', bound=Child)


class Children:
    """All that was declared through one session or node, by gid; safe from any thread."""

    def __init__(self, parent: EndpointState) -> None:
        self._parent = parent
        self._lock = RLock()  # reentrant: a finalizer may close a child while its thread holds the lock
        self._children: dict[bytes, Child] = {}

    @contextmanager
    def opening(self, title: str, logger: str = '') -> Iterator[EndpointState]:
        """Open a child in the block, which adds the steps of closing to `undo` and calls `keep` at the end.

        If the block fails, or the parent is closed meanwhile, the steps in `undo` are run. Raises ClosedError
        or ForkedError if the parent is not open.
        """
        parent = self._parent
        parent.check()
        state = EndpointState(title, parent.guard, logger or parent.logger)
        try:
            yield state
        except BaseException as error:
            state.close()
            if isinstance(error, Exception):
                parent.check()  # opening may have failed because another thread has closed the parent
            raise

    def keep(self, child: C) -> C:
        """Add a child, which is completely open, and return it.

        Raises ClosedError if the parent is closed. So closing the parent closes all children, and none is
        added later. A child is discarded in the last step of its closing: until then the closing of the
        parent waits for it.
        """
        with self._lock:
            if not self._parent.closed:
                child.state.undo.insert(0, partial(self.discard, child.gid))
                self._children[child.gid] = child
                return child
        self._parent.check()
        return child

    def discard(self, gid: bytes) -> None:
        """Remove a child that was closed; an unknown one is ignored."""
        with self._lock:
            self._children.pop(gid, None)

    def close(self) -> None:
        """Close all children."""
        with self._lock:
            children = list(self._children.values())
        for child in children:
            child.state.close()


class OpenPort(Port):
    """A port that is open until its state is closed."""

    def __init__(self, state: EndpointState, gid: bytes) -> None:
        self.state = state
        self.gid = gid

    def close(self) -> None:
        """Undeclare."""
        self.state.close()


class OpenNode(NodePort):
    """A node and the ports that were declared through it."""

    def __init__(self, state: EndpointState, gid: bytes) -> None:
        self.state = state
        self.gid = gid
        self.ports = Children(state)

    def close(self) -> None:
        """Close every port, then leave the graph."""
        self.state.close()


class OpenSession(Session):
    """A session and its nodes."""

    def __init__(self, domain_id: int, guard: ForkGuard) -> None:
        self.state = EndpointState(f'session of domain {domain_id}', guard)
        self.nodes = Children(self.state)

    def silence(self) -> None:
        """Refuse to send from now on: publishers and clients raise ClosedError."""
        self.state.guard.silence()

    def close(self) -> None:
        """Close every node, send the queued messages, and leave the wire."""
        self.state.close()


# -- the end of the interpreter ------------------------------------------------------------------------------


class Closable(Protocol):
    """Something that is closed at exit."""

    def close(self) -> None:
        """Close; idempotent."""


_open: WeakMembers[Closable] = WeakMembers()


def close_at_exit(closable: Closable) -> None:
    """Close something when the interpreter ends, while its threads can still run callbacks."""
    _open.add(closable)


def _close_all() -> None:
    perform([closable.close for closable in _open.alive()])


def _leak_all() -> None:
    for closable in _open.alive():
        leak(closable)


at_exit(Stage.SESSIONS, _close_all)
in_child(_leak_all)


# -- what sessions share -------------------------------------------------------------------------------------

K = TypeVar('K', bound=Hashable)
V = TypeVar('V')


class Shared(Generic[K, V]):
    """Things that several users share, by key: each is made for its first user, and ended by its last."""

    def __init__(self, end: Callable[[V], object] | None = None) -> None:
        self._end = end
        self._reset()
        # A forked child cannot use the parent's things, and another thread may have held the lock.
        in_child(self._reset)

    def _reset(self) -> None:
        self._lock = Lock()
        self._things: dict[K, tuple[V, int]] = {}

    def open(self, key: K, make: Callable[[], V]) -> V:
        """Return the thing for one more user; `make` makes it if there is none. Raises as `make` does."""
        with self._lock:
            thing, users = self._things.get(key) or (make(), 0)
            self._things[key] = thing, users + 1
            return thing

    def get(self, key: K) -> V | None:
        """Return the thing, or None, without becoming its user; takes no lock."""
        found = self._things.get(key)
        return None if found is None else found[0]

    def close(self, key: K) -> None:
        """Give the thing back for one user; an unknown key is ignored.

        The last user ends the thing. A new thing is made only after the old one has ended.
        """
        with self._lock:
            if key not in self._things:
                return
            thing, users = self._things[key]
            if users > 1:
                self._things[key] = thing, users - 1
                return
            del self._things[key]
            if self._end is not None:
                self._end(thing)

    def close_all(self) -> None:
        """End all things, even used ones."""
        with self._lock:
            things, self._things = self._things, {}
            for thing, _ in things.values():
                if self._end is not None:
                    self._end(thing)

    def things(self) -> list[V]:
        """Return all things; takes no lock."""
        return [thing for thing, _ in self._things.values()]

    def users(self) -> int:
        """Return how many users a thing has."""
        with self._lock:
            return sum(users for _, users in self._things.values())

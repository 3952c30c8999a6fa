"""A lock for code that a signal's handler or a finalizer may interrupt on the same thread.

Python runs a signal's handler on the main thread between any two bytecodes, and a finalizer on whichever
thread has dropped or collected the last reference. Both may publish while the interrupted code is publishing.
A plain lock would then wait for its own thread for ever. A re-entrant lock would let them in, and two
messages would change places. So a call that finds its own thread in the section leaves its work in a list.
The thread does that work in order when it leaves, before any other thread enters.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import RLock


class CriticalSection:
    """A lock, and the calls that its holder has left for later.

    Hot paths write out the steps of `run` in their own code, to save its calls:

        entered = False
        try:
            section.acquire()  # inside `try`: a handler may raise as soon as the lock is taken
            if section.is_busy:
                section.late.append(...)
                return
            if section.late:
                section.run_late()
            entered = section.is_busy = True
            ...
        finally:
            try:
                if entered:
                    section.is_busy = False
                    if section.late:
                        section.run_late()
            finally:
                try:
                    section.release()
                except RuntimeError:  # a signal's handler raised while this waited for the lock
                    pass
    """

    __slots__ = ('acquire', 'is_busy', 'late', 'lock', 'mend', 'release')

    def __init__(self, mend: Callable[[], object] = lambda: None) -> None:
        """`mend` repairs half-done work after an exception in `run` or `run_late`; it is called inside the
        section.
        """
        self.mend = mend
        self.lock = RLock()
        self.acquire, self.release = self.lock.acquire, self.lock.release
        self.is_busy = False
        """True while the lock's holder is doing work. Only the holder may read this."""
        self.late: deque[Callable[[], object]] = deque()
        """The calls that the holder's own thread has made while it was busy; it does them when it leaves."""

    def run(self, do: Callable[[], object]) -> bool:
        """Call `do` while no other thread is in the section. If this call interrupts work of the same thread
        in the section, return False: `do` is called after that work.

        An error of `do` is raised here only if `do` is called here.
        """
        with self.lock:
            if self.is_busy:
                self.late.append(do)
                return False
            if self.late:  # this call interrupts an outer `run`, which was about to do the late work
                self.run_late()
            try:
                self.is_busy = True
                do()
            except BaseException:
                self.mend()
                raise
            finally:
                self.is_busy = False
                if self.late:
                    self.run_late()
        return True

    def run_late(self) -> None:
        """Do the work that was left for later. The caller must hold the lock, and have no half-done work."""
        late = self.late
        while late:
            try:
                self.is_busy = True
                while late:
                    late.popleft()()
            except BaseException:
                self.mend()
                raise
            finally:
                self.is_busy = False

    def is_entered(self) -> bool:
        """True if the calling thread is doing work in this section."""
        if not self.lock.acquire(blocking=False):
            return False
        try:
            return self.is_busy
        finally:
            self.lock.release()

"""A lock for code that something on its own thread may interrupt: a signal's handler, or a finalizer.

Python runs a signal's handler on the main thread between any two of its steps, and a finalizer on whichever
thread has dropped or collected the last reference. Both may publish while their thread is just publishing. A
plain lock would then wait for itself. A re-entrant one lets them in, and two messages change places. So
whoever finds its own thread in here leaves what it wants done, and the thread does that on its way out, in
order, before any other thread comes in.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import RLock


class CriticalSection:
    """One lock, and what waits for the thread that has it.

    Hot paths do what `run` does in their own code, to save its calls:

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
        """Whether the thread that has the lock is in the midst of something. Only that thread may ask."""
        self.late: deque[Callable[[], object]] = deque()
        """The calls that the same thread has asked for meanwhile."""

    def run(self, do: Callable[[], object]) -> bool:
        """Do something while no other thread is in the section. Return False if this call interrupts the
        thread's own work in the section; it is done after that.

        What `do` raises is raised here in the first case only.
        """
        with self.lock:
            if self.is_busy:
                self.late.append(do)
                return False
            if self.late:  # this interrupts the code that was about to do that, on its way out
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
        """Do the work that was left for later; under the lock, on the way out or before other work."""
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
        """Whether the calling thread is in the midst of something in here."""
        if not self.lock.acquire(blocking=False):
            return False
        try:
            return self.is_busy
        finally:
            self.lock.release()

"""A wire that refuses: one call of a transport's method fails."""

from __future__ import annotations

from dataclasses import dataclass, field
from fnmatch import fnmatchcase

from goalwire.errors import TransportError


@dataclass(eq=False)
class FailedCall:
    """The `nth` call of `method` ('publish', 'session.close', …; any, by default) raises TransportError."""

    method: str = '*'
    nth: int = field(default=1, kw_only=True)
    struck: int = field(default=0, init=False)
    struck_method: str = field(default='', init=False)
    """Which it was."""
    _met: int = field(default=0, init=False, repr=False)

    def check(self, method: str) -> None:
        """Count a call; raises TransportError where it is the one."""
        if self.struck or not fnmatchcase(method, self.method):
            return
        self._met += 1
        if self._met == self.nth:
            self.struck, self.struck_method = 1, method
            raise TransportError(f"'{method}' failed: a fault injected as call {self.nth} of '{self.method}'")

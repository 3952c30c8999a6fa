"""One thing that `ros2 doctor` looks at."""

from __future__ import annotations

from typing import NamedTuple


class Check(NamedTuple):
    """The result of one check; `advice` says what to do if it failed."""

    name: str
    is_well: bool
    found: str
    advice: str = ''
    is_needed: bool = True
    """False if the result is only information, such as a wire that is neither selected nor usable."""

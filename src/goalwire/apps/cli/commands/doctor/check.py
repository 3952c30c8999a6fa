"""One thing that `ros2 doctor` looks at."""

from __future__ import annotations

from typing import NamedTuple


class Check(NamedTuple):
    """One thing that was looked at; `advice` if it is not well."""

    name: str
    is_well: bool
    found: str
    advice: str = ''
    is_needed: bool = True
    """False for what is only worth knowing, such as a wire that is not selected and cannot be used."""

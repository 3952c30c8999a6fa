"""xacro: makes a URDF of macros, by the package of this name from PyPI or Debian."""

from __future__ import annotations

import sys

ADVICE = 'xacro: it is not installed; run: pip install xacro'


def main() -> int:
    """Run it with the words of the command line; returns the exit code."""
    try:
        import xacro
    except ModuleNotFoundError:
        print(ADVICE, file=sys.stderr)
        return 1
    return int(xacro.main() or 0)

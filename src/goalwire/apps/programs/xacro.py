"""xacro: expands the macros of a URDF, with the package `xacro` from PyPI or Debian."""

from __future__ import annotations

import sys

ADVICE = 'xacro: it is not installed; run: pip install xacro'


def main() -> int:
    """Run xacro with the arguments of the command line; return the exit code."""
    try:
        import xacro
    except ModuleNotFoundError:
        print(ADVICE, file=sys.stderr)
        return 1
    return int(xacro.main() or 0)

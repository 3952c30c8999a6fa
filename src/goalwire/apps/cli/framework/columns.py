"""Tables for people."""

from __future__ import annotations

from collections.abc import Sequence

from goalwire.apps.cli.framework.output import spell_out


def align(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the rows as lines, in columns as wide as their widest cell. The last column may have any width.

    Control characters are spelt out, so that the widths are those on the terminal.
    """
    cells = [[spell_out(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return [
        '  '.join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in cells
    ]

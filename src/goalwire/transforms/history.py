"""The history of one link of the tree: a frame's pose in its parent frame, over time or static.

Times are in ns; the time LATEST (0) stands for the newest known time.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from typing import NamedTuple

from goalwire.errors import ExtrapolationException
from goalwire.transforms.rigid import Rigid

LATEST = 0


class Link(NamedTuple):
    """A frame's parent frame, and the transform from the frame to its parent."""

    parent: str
    motion: Rigid


class FixedLink:
    """A static transform: the last link that was inserted is valid at all times."""

    def __init__(self) -> None:
        self._link: Link | None = None
        self.stamps = [LATEST]

    def insert(self, stamp: int, link: Link) -> bool:  # noqa: ARG002 - a History needs the stamp
        """Store a link in place of the earlier link; return True."""
        self._link = link
        return True

    def at(self, time: int) -> Link | None:  # noqa: ARG002 - it does not matter
        """Return the link; None if no link was inserted yet."""
        return self._link


class History:
    """A moving transform: the links of the last `span` ns. Between two links the transform
    is interpolated.
    """

    def __init__(self, span: int) -> None:
        self._span = span
        self.stamps: list[int] = []
        """The times of the links, ascending."""
        self._links: list[Link] = []

    def insert(self, stamp: int, link: Link) -> bool:
        """Store a link; return False if it is more than `span` older than the newest. A duplicate changes
        nothing.
        """
        if self.stamps and stamp < self.stamps[-1] - self._span:
            return False
        first, place = bisect_left(self.stamps, stamp), bisect_right(self.stamps, stamp)
        if link not in self._links[first:place]:
            self.stamps.insert(place, stamp)
            self._links.insert(place, link)
        outdated = bisect_left(self.stamps, self.stamps[-1] - self._span)
        del self.stamps[:outdated], self._links[:outdated]
        return True

    def at(self, time: int) -> Link | None:
        """Return the link at a time; None if no link is stored. Raises ExtrapolationException.

        Between two links with different parents the older link is valid.
        """
        if not self.stamps:
            return None
        if time == LATEST:
            return self._links[-1]
        after = bisect_right(self.stamps, time)
        if after and self.stamps[after - 1] == time:
            return self._links[after - 1]
        if not 0 < after < len(self.stamps):
            raise self._extrapolation(time)
        older, newer = self._links[after - 1], self._links[after]
        if older.parent != newer.parent:
            return older
        start, end = self.stamps[after - 1], self.stamps[after]
        return Link(older.parent, older.motion.towards(newer.motion, (time - start) / (end - start)))

    def _extrapolation(self, time: int) -> ExtrapolationException:
        oldest, newest = self.stamps[0], self.stamps[-1]
        text = 'Lookup would require extrapolation'
        if len(self.stamps) == 1:
            text += f' at time {seconds(time)}, but only time {seconds(newest)} is in the buffer'
        elif time > newest:
            text += f' into the future.  Requested time {seconds(time)} but the latest data is at time '
            text += seconds(newest)
        else:
            text += f' into the past.  Requested time {seconds(time)} but the earliest data is at time '
            text += seconds(oldest)
        return ExtrapolationException(text)


def seconds(time: int) -> str:
    """Return a time in ns as text in tf2's form: seconds with six decimals."""
    return f'{time / 1e9:.6f}'

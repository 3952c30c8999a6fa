"""The links of a session that are up: at most one to each other session."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.primitives import MAX_LINKS, ZenohProtocolError


class Links:
    """The links that are up. Code that changes them holds the session's section; any thread may read `up`."""

    def __init__(self, own_zid: bytes, close: Callable[[Link, str, int], None]) -> None:
        """`close` closes a link soon and does not block; it gets a text and Zenoh's number of the reason."""
        self.up: tuple[Link, ...] = ()
        self._own_zid = own_zid
        self._close = close

    def is_linked(self, zid: bytes) -> bool:
        """Return whether there is a link to a session."""
        return any(link.zid == zid for link in self.up)

    def add(self, link: Link) -> None:
        """Add a link. Raises ZenohProtocolError if an existing link to the same session is kept instead."""
        self._settle_duplicate(link)
        self.up += (link,)

    def _settle_duplicate(self, link: Link) -> None:
        """Of two links to a session, keep the link that the session with the greater id has opened.

        Both sides follow this rule, so they close the same link.
        """
        for other in self.up:
            if other.zid == link.zid:
                if link.guard is not None and other.guard is not None and link.guard.who != other.guard.who:
                    raise ZenohProtocolError('the session of another identity has this id', MAX_LINKS)
                connector = self._own_zid if link.handshake.connects else link.zid
                before = self._own_zid if other.handshake.connects else other.zid
                # `<=`: if the same side has opened both links, the existing link stays.
                if connector <= before:
                    raise ZenohProtocolError('there is a link to this session already', MAX_LINKS)
                self.remove(other)
                self._close(other, 'another link to this session replaces it', MAX_LINKS)

    def remove(self, link: Link) -> None:
        """Remove a link. An unknown link changes nothing."""
        self.up = tuple(each for each in self.up if each is not link)

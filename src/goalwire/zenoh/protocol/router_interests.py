"""The entities that a session asks routers for.

Peers tell each other everything, but a router tells only what it is asked for. A session asks for everything,
or for the entities in some keys only: then its cost does not grow with all other entities of the router.
Keys that the session uses later are asked for, too, so that it reaches everybody whom it can name.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from goalwire.zenoh.protocol.declarations import About, When, interest
from goalwire.zenoh.protocol.key_expressions import includes
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.links import Links

_WHEN = When.PRESENT | When.FUTURE
_ENTITIES = About.SUBSCRIBERS | About.QUERYABLES


class RouterInterests:
    """The INTERESTs that one session sends to its routers. Callers hold the session's section."""

    def __init__(self, links: Links, next_number: Callable[[], int]) -> None:
        self.token_keys: list[str] = []
        """The key expressions of the tokens; empty: all. Routers with access control need to know them."""
        self.entity_keys: list[str] | None = None
        """The key expressions of the subscribers and queryables; None: all."""
        self._links = links
        self._next_number = next_number

    @property
    def is_narrow(self) -> bool:
        """True if this session learns only of subscribers and queryables in keys that it has named."""
        return self.entity_keys is not None

    def ask_all(self, link: Link) -> list[bytes]:
        """Return the INTERESTs to send to a router over a new link."""
        if not self.token_keys:
            return [interest(self._next_number(), _WHEN, About.ALL)]
        asked = [interest(self._next_number(), _WHEN, About.TOKENS, key) for key in self.token_keys]
        keys: Sequence[str | None] = (None,) if self.entity_keys is None else self.entity_keys
        return [*asked, *(self._ask_entities(link, key) for key in keys)]

    def _ask_entities(self, link: Link, key: str | None) -> bytes:
        """Return an INTEREST. Until it is answered, the router gets every message and query."""
        number = self._next_number()
        link.peer.awaited.add(number)
        link.peer.knows_all = False
        return interest(number, _WHEN, _ENTITIES, key)

    def add_token_key(self, key: str) -> None:
        """Ask for tokens, unless an earlier INTEREST covers them."""
        if self.token_keys and self._is_new(self.token_keys, key):
            for link in self._routers():
                link.outgoing.declare(interest(self._next_number(), _WHEN, About.TOKENS, key))

    def add_entity_key(self, key: str) -> None:
        """Ask for the subscribers and queryables of a key, unless an earlier INTEREST covers it."""
        if self.entity_keys is not None and self._is_new(self.entity_keys, key):
            for link in self._routers():
                link.outgoing.declare(self._ask_entities(link, key))

    @staticmethod
    def _is_new(asked: list[str], key: str) -> bool:
        """Add a key to those that are asked for; False if these cover the key already."""
        if any(includes(each, key) for each in asked):
            return False
        asked.append(key)
        return True

    def _routers(self) -> list[Link]:
        return [link for link in self._links.up if link.role is Role.ROUTER]

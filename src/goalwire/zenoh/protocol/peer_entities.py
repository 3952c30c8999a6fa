"""The entities that the other side of a link has declared, within the bounds of one link.

The other side gives numbers to its keys and entities, and undeclares them by number. Code that changes these
tables holds the session's section. Code that runs for each message reads a few of them without it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.declarations import About, Declaration, Interest, Kind, When
from goalwire.zenoh.protocol.key_expressions import intersects
from goalwire.zenoh.protocol.key_index import KeyIndex, is_odd
from goalwire.zenoh.protocol.primitives import show_id

_ABOUT = {Kind.SUBSCRIBER: About.SUBSCRIBERS, Kind.QUERYABLE: About.QUERYABLES, Kind.TOKEN: About.TOKENS}


class PeerEntities:
    """The keys, subscribers, queryables, tokens and interests of one link's other side."""

    def __init__(self, own_keys: Mapping[int, str], refuse: Callable[[str, object], object]) -> None:
        """`own_keys` are this session's keys by number; `refuse` gets an ignored message's kind and the
        reason.
        """
        self.zid = b''
        """The other side's id; empty before the end of the handshake."""
        self.expressions: dict[int, str] = {}
        self.expression_ids: dict[str, int] = {}
        self.subscribers: KeyIndex[None] = KeyIndex()
        self.queryables: KeyIndex[tuple[bool, int]] = KeyIndex()
        self.tokens: dict[int, str] = {}
        self.interests: dict[int, Interest] = {}
        self.size = 0
        """Bytes of the other side's declarations, as `bounds.DECLARED_LIMIT` counts them."""
        self.told: set[int] = set()
        """The numbers of this session's keys that the other side knows."""
        self.told_of: set[int] = set()
        """The numbers of this session's entities that a client or a guarded side has been told about."""
        self.knows_all = False
        """True once the other side has declared everything; until then it gets every message and query."""
        self.awaited: set[int] = set()
        """The numbers of this session's interests in some keys that a router has not answered yet."""
        self._own_keys = own_keys
        self._refuse = refuse

    def key_of(self, scope: int, suffix: bytes | str, is_senders: int) -> str | None:
        """Return the key that the other side names by a number, by a text, or by a number and a suffix.

        None for an unknown number, and for a key beyond the bounds.
        """
        if len(suffix) > bounds.KEY_LIMIT:
            self._refuse('key', f'it has {len(suffix)} bytes, {bounds.KEY_LIMIT} are allowed')
            return None
        key = suffix if isinstance(suffix, str) else suffix.decode()
        if scope:
            # Both sides number keys for themselves; a flag of the message shows whose number it is.
            base = (self.expressions if is_senders else self._own_keys).get(scope)
            if base is None:
                return None
            key = base + key
            if len(key) > bounds.KEY_LIMIT:
                self._refuse('key', f'it has {len(key)} characters, {bounds.KEY_LIMIT} are allowed')
                return None
        if '*' in key and key.count('*') > bounds.WILD_SIGNS:
            self._refuse('key', f'it has {key.count("*")} asterisks, {bounds.WILD_SIGNS} are allowed')
            return None
        return key

    # ---- what the other side declares

    def add_expression(self, number: int, key: str) -> bool:
        """Keep the number of a key. Return False if the number is in use, or the bounds are exceeded."""
        if not number or number in self.expressions or not self._allows(len(key)):
            return False
        self.expressions[number] = key
        self.expression_ids[key] = number
        return True

    def remove_expression(self, number: int) -> bool:
        """Forget the number of a key. Return False if it was unknown."""
        key = self.expressions.pop(number, None)
        if key is None:
            return False
        self._free(len(key))
        # The other side may have declared a second number for the same key.
        if self.expression_ids.get(key) == number:
            del self.expression_ids[key]
        return True

    def add_token(self, number: int, key: str) -> bool:
        """Keep a token. Return False if its number is in use, or the bounds are exceeded."""
        if number in self.tokens or not self._allows(len(key)):
            return False
        self.tokens[number] = key
        return True

    def remove_token(self, number: int) -> str | None:
        """Forget a token and return its key; None if it was unknown."""
        token = self.tokens.pop(number, None)
        if token is not None:
            self._free(len(token))
        return token

    def add_entity(self, declaration: Declaration, key: str) -> None:
        """Keep a subscriber or a queryable. It replaces an entity with the same number."""
        kind, number = declaration.kind, declaration.number
        self.remove_entity(kind, number)
        index = self.subscribers if kind is Kind.SUBSCRIBER else self.queryables
        if is_odd(key) and index.odd >= bounds.MOST_WILD:
            self._refuse('declaration', f'session {show_id(self.zid)} has {index.odd} with wildcards')
        elif self._allows(len(key)):
            if kind is Kind.SUBSCRIBER:
                self.subscribers.add(number, key, None)
            else:
                self.queryables.add(number, key, (declaration.complete, declaration.distance))

    def remove_entity(self, kind: Kind, number: int) -> None:
        """Forget a subscriber or a queryable. An unknown number changes nothing."""
        found = (self.subscribers if kind is Kind.SUBSCRIBER else self.queryables).pop(number)
        if found is not None:
            self._free(len(found[0]))

    def has(self, kind: Kind, number: int) -> bool:
        """Return whether an entity of the other side is kept under a number."""
        if kind is Kind.TOKEN:
            return number in self.tokens
        return number in (self.subscribers if kind is Kind.SUBSCRIBER else self.queryables)

    # ---- what the other side asks for

    def add_interest(self, wish: Interest) -> None:
        """Keep an interest of the other side, unless it has too many."""
        if len(self.interests) >= bounds.MOST_INTERESTS:
            self._refuse('interest', f'session {show_id(self.zid)} has {bounds.MOST_INTERESTS} of them')
        elif self._allows(len(wish.suffix)):
            self.interests[wish.number] = wish

    def remove_interest(self, number: int) -> None:
        """Forget an interest. An unknown number changes nothing."""
        before = self.interests.pop(number, None)
        if before is not None:
            self._free(len(before.suffix))

    def wants(self, kind: Kind, key: str) -> bool:
        """Return whether the other side has asked for future entities of this kind and key."""
        return any(
            each.when & When.FUTURE and self.is_met(each, kind, key) for each in self.interests.values()
        )

    def is_met(self, wish: Interest, kind: Kind, key: str) -> bool:
        """Return whether an interest asks for entities of this kind and key."""
        return bool(_ABOUT[kind] & wish.about) and self.is_about(wish, key)

    def is_about(self, wish: Interest, key: str) -> bool:
        """Return whether an interest asks for entities on a key. Without a key an interest asks for all."""
        if not wish.has_key:
            return True
        wanted = self.find_key(wish)
        return wanted is not None and intersects(wanted, key)

    def find_key(self, wish: Interest) -> str | None:
        """Return the key that an interest names; None for an unknown number, or beyond the bounds."""
        return self.key_of(wish.scope, wish.suffix, wish.is_senders)

    # ---- bounds

    def _allows(self, size: int) -> bool:
        """Reserve room for a declaration whose key has `size` characters; return False if there is none."""
        cost = size + bounds.DECLARED_COST
        if self.size + cost > bounds.DECLARED_LIMIT:
            self._refuse(
                'declaration', f'session {show_id(self.zid)} has declared {bounds.DECLARED_LIMIT >> 20} MiB'
            )
            return False
        self.size += cost
        return True

    def _free(self, size: int) -> None:
        self.size -= size + bounds.DECLARED_COST

"""The connections that a session opens: to configured addresses, and to nodes that routers have announced."""

from __future__ import annotations

import socket
from collections.abc import Callable

from goalwire.concurrency.poller import Poller
from goalwire.zenoh.io.dialler import Dial, DialSlots, LookUps, Retry
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.gossip import Gossip
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.link_state import Node, connects_to

_TO_NODES = Retry(first_s=0.1, most_s=4.0, rounds=10)


class Dials:
    """One session's dials, and the links that they have led to."""

    def __init__(
        self,
        poller: Poller,
        gossip: Gossip,
        own_zid: bytes,
        take: Callable[[Dial, socket.socket], None],
        note_failure: Callable[[], None],
    ) -> None:
        """`take` gets each connected socket; `note_failure` is called after each failed round."""
        self._poller = poller
        self._gossip = gossip
        self._own_zid = own_zid
        self._take = take
        self._note_failure = note_failure
        self._dials: dict[object, Dial] = {}
        """The dials by their configured addresses, or by the id of a node from gossip."""
        self._dialled: dict[Link, Dial] = {}
        self._slots = DialSlots(bounds.MOST_DIALS)
        self._look_ups = LookUps(bounds.MOST_LOOK_UPS)

    def start(self, groups: list[tuple[str, ...]], retry: Retry, open_s: float) -> None:
        """Begin to connect to one address of each group. A handshake may take `open_s` at most."""
        dials = [self._add(group, group, retry, open_s=open_s) for group in groups]
        for dial in dials:
            self._poller.call(dial.start)

    def meet(self, node: Node) -> None:
        """Connect to a node from gossip. Only the thread that reads calls this."""
        self._add(node.zid, node.locators, _TO_NODES, node.zid).start()

    def is_meeting(self, zid: bytes) -> bool:
        """True while a node from gossip is dialled, or linked because it was dialled."""
        return zid in self._dials

    def _add(
        self,
        name: object,
        locators: tuple[str, ...],
        retry: Retry,
        expected: bytes | None = None,
        open_s: float | None = None,
    ) -> Dial:
        dial = Dial(
            locators,
            self._poller,
            retry,
            when_connected=self._take,
            when_failed=self._note_failed,
            expected=expected,
            open_s=open_s,
            slots=None if expected is None else self._slots,
            look_ups=None if expected is None else self._look_ups,
        )
        self._dials[name] = dial
        return dial

    def _note_failed(self, dial: Dial) -> None:
        if dial.is_over and dial.expected is not None:
            self._dials.pop(dial.expected, None)
            self._gossip.forget(dial.expected)
        self._note_failure()

    # ---- the links that the dials lead to

    def keep(self, dial: Dial, link: Link) -> None:
        """Remember which dial has led to a link."""
        self._dialled[link] = dial

    def is_shaking_hands(self, zid: bytes) -> bool:
        """True if this side has dialled the session, and the handshake with it is under way."""
        return any(dial.expected == zid and not link.is_up for link, dial in list(self._dialled.items()))

    def note_up(self, link: Link) -> None:
        """Take note that a link is up; another dial for the same session ends."""
        dial = self._dialled.get(link)
        if dial is not None:
            dial.note_success()
        other = self._dials.get(link.zid)
        if other is not None and other is not dial:
            other.close()
            self._dials.pop(link.zid, None)

    def forget(self, link: Link) -> Dial | None:
        """Forget an ended link. Return the dial that had led to it; None if the other side opened it."""
        return self._dialled.pop(link, None)

    def dial_again(self, dial: Dial, link: Link, why: str, *, is_linked: bool, took_too_long: bool) -> None:
        """Connect again after the end of a link that `dial` had led to, unless the node is linked again.

        `took_too_long`: its handshake did.
        """
        if is_linked and dial.expected is not None:
            dial.close()
            self._dials.pop(dial.expected, None)
            return
        dial.error = why
        if link.terms is not None:
            dial.try_again()
        else:
            dial.note_refusal(took_too_long=took_too_long)

    def node_to_meet(self, zid: bytes) -> Node | None:
        """Return a lost node if this side has to dial it again; else forget it, since it dials this side."""
        node = self._gossip.nodes.get(zid)
        if node is not None and not connects_to(self._own_zid, node):
            self._gossip.forget(zid)
            return None
        return node

    def address_of(self, link: Link) -> str:
        """Return the address that was dialled for a link; empty if the other side has opened it."""
        dial = self._dialled.get(link)
        return '' if dial is None else dial.address

    # ---- the progress of the dials

    def is_connected(self) -> bool:
        """True if the link to at least one of the configured addresses is up."""
        return any(dial.is_up for dial in list(self._dials.values()) if dial.expected is None)

    def have_settled(self, *, go_on: bool) -> bool:
        """True if each dial is connected or has failed once; with `go_on`, failing is not enough."""
        return all(dial.is_up or (dial.failed_rounds and not go_on) for dial in list(self._dials.values()))

    def missing(self) -> list[Dial]:
        """Return the dials of configured addresses that have led to no link."""
        return [dial for dial in list(self._dials.values()) if dial.expected is None and not dial.is_up]

    # ---- the end

    def close(self) -> None:
        """Stop dialling, and close what is being dialled."""
        self._look_ups.clear()
        for dial in list(self._dials.values()):
            dial.close()

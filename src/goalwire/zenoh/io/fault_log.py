"""Log lines about links that were closed because their other side broke the protocol."""

from __future__ import annotations

from collections import Counter

from goalwire.errors import peer_text
from goalwire.fault_reports import LOGGER, is_told
from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.primitives import show_id


class FaultLog:
    """The fault log of one session. It logs the first fault of each kind, then the tenth, the hundredth."""

    def __init__(self, session: str) -> None:
        """`session` is the id that log lines begin with."""
        self._session = session
        self._faults: Counter[str] = Counter()

    def tell(self, link: Link, why: str) -> None:
        """Count a closed link, and log the reason if its count is 1, 10, 100 and so on."""
        kind = ''.join(sign for sign in why if not sign.isdigit())
        if kind not in self._faults and len(self._faults) >= bounds.MOST_FAULTS:
            kind = ''
        self._faults[kind] += 1
        count = self._faults[kind]
        if is_told(count):
            times = '' if count == 1 else f' ({count} links by now for that reason)'
            name = f'session {show_id(link.zid)}' if link.zid else 'an unknown session'
            self.warn(f'the link to {name} was closed: {peer_text(why)}{times}')

    def warn(self, text: str) -> None:
        """Log a warning of this session's."""
        from goalwire.logging import get_logger  # imported here, since it is needed only after a fault

        get_logger(LOGGER).warning(f'Zenoh session {self._session}: {text}')

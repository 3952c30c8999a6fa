"""A router for a whole site: all machines that reach it find each other through it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import zenoh

from goalwire.errors import AddressTakenError, TransportError
from goalwire.fault_reports import LOGGER
from goalwire.security.environment import Chosen
from goalwire.transport.zenoh import eclipse_library
from goalwire.transport.zenoh.embedded_router import PORT_IS_TAKEN
from goalwire.transport.zenoh.rendezvous import name_of_holder
from goalwire.transport.zenoh.settings.plan import router_config
from goalwire.transport.zenoh.settings.secured_rmw_zenoh import rules_of


@contextmanager
def router(
    port: int, listen: Sequence[str], connect: Sequence[str], identity: Chosen | None = None
) -> Iterator[str]:
    """Run a router in the block; yields its id. Raises AddressTakenError and other TransportErrors.

    The router listens at `listen`, or on `port` of every address if `listen` is empty, and connects to the
    routers in `connect`. ZENOH_ROUTER_CONFIG_URI and ZENOH_CONFIG_OVERRIDE apply, as for rmw_zenoh's router.
    With an identity the router speaks mutual TLS and enforces its keystore's policy; raises SecurityError if
    that policy is unusable.
    """
    rules = None if identity is None else rules_of(identity)
    settings = router_config(port, listen, connect, identity, rules)
    try:
        opened = eclipse_library.open_zenoh(settings)
    except zenoh.ZError as error:
        if PORT_IS_TAKEN in str(error):
            raise AddressTakenError(
                f'port {port} is held by {name_of_holder(port)}; end it first, or give another --port'
            ) from None
        raise TransportError(
            f'the router cannot be opened: {eclipse_library.reason(error)}; see --listen and --connect'
        ) from None
    try:
        yield str(opened.info.zid())
    finally:
        _close(opened)


def _close(opened: zenoh.Session) -> None:
    """Close a router. Zenoh gives up after 10 s, for example if a session does not read."""
    try:
        opened.close()  # type: ignore[no-untyped-call]
    except zenoh.ZError as error:
        from goalwire.logging import get_logger  # imported here: needed only for a warning

        why = eclipse_library.reason(error)
        get_logger(LOGGER).warning(f'the router could not close all its links: {why}; its process ends them')

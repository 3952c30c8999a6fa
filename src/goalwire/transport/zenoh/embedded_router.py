"""Opens a rendezvous's router: goalwire's own, or eclipse-zenoh's if the configuration needs more."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from goalwire.errors import AddressTakenError, TransportError
from goalwire.fault_reports import LOGGER
from goalwire.transport.zenoh.settings import environment
from goalwire.transport.zenoh.settings.native import BeyondOursError, router_settings
from goalwire.transport.zenoh.settings.values import Configuration

PORT_IS_TAKEN = 'listener'
"""The text in zenoh's error for a port that cannot be bound; other errors are about the configuration."""
_CHECK = 'check ZENOH_ROUTER_CONFIG_URI and ZENOH_CONFIG_OVERRIDE, or set GOALWIRE_ROUTER=off'


class OpenRouter(Protocol):
    """A router that runs."""

    def close(self) -> None:
        """Release the port, and close all links."""


def open_router(port: int, config: Configuration, before_eclipse: Callable[[], None]) -> OpenRouter:
    """Open the router; `before_eclipse` is called before eclipse-zenoh opens sockets.

    Raises AddressTakenError, other TransportErrors, and ForkedError if the parent of this process has used
    eclipse-zenoh and this process is to use it, too.
    """
    if environment.zenoh_choice() == environment.ECLIPSE:
        before_eclipse()
        return _open_eclipse(port, config, f'{environment.CHOICE}={environment.ECLIPSE}')
    try:
        settings = router_settings(config.values)
    except BeyondOursError as error:
        from goalwire.logging import get_logger

        get_logger(LOGGER).info(f"the rendezvous is eclipse-zenoh's: its configuration asks for {error}")
        before_eclipse()
        return _open_eclipse(port, config, f'its configuration asks for {error}. That')
    from goalwire.zenoh.io.native_session import NativeSession

    try:
        return NativeSession(settings)
    except AddressTakenError:
        raise
    except TransportError as error:
        raise TransportError(f'the rendezvous on port {port} cannot be offered: {error}; {_CHECK}') from None


def _open_eclipse(port: int, config: Configuration, why: str) -> OpenRouter:
    try:
        import zenoh

        from goalwire.transport.zenoh import eclipse_library
    except ImportError as error:
        if error.name != 'zenoh':
            raise
        raise TransportError(
            f'the rendezvous on port {port} cannot be offered: {why} needs eclipse-zenoh, which is not '
            f'installed: run {environment.INSTALL_ECLIPSE}, or set GOALWIRE_ROUTER=off and start a router'
        ) from None
    try:
        return eclipse_library.open_zenoh(config)
    except zenoh.ZError as error:
        if PORT_IS_TAKEN in str(error):
            raise AddressTakenError(f'port {port} is taken') from None
        raise TransportError(
            f'the rendezvous on port {port} cannot be offered: {eclipse_library.reason(error)}; {_CHECK}'
        ) from None

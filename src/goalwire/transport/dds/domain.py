"""Domains of the library: one per domain id and process, made by the first session, ended by the last."""

from __future__ import annotations

from goalwire.errors import TransportError
from goalwire.transport.dds.abi import Library
from goalwire.transport.dds.configuration import LARGEST_DOMAIN, domain_configuration
from goalwire.transport.dds.reader_dispatcher import LocalReaders
from goalwire.transport.endpoint import Shared


class Domain:
    """One domain and the readers of its sessions in this process."""

    def __init__(self, library: Library, domain_id: int, configuration: str) -> None:
        """Raises TransportError."""
        self._library = library
        self._handle = library.dds_create_domain(domain_id, configuration.encode())
        if self._handle < 0:
            raise TransportError(
                f'Cyclone DDS refused the configuration of domain {domain_id} '
                f'({library.dds_strretcode(self._handle).decode()}): it has written why to standard error; '
                f'check CYCLONEDDS_URI and ROS_STATIC_PEERS'
            )
        self.local_readers = LocalReaders()

    def close(self) -> None:
        """End it."""
        self._library.dds_delete(self._handle)


DOMAINS: Shared[int, Domain] = Shared(Domain.close)
"""The domains that sessions of this process are in, by domain id."""


def open_domain(library: Library, domain_id: int) -> Domain:
    """Return the domain for one more session; raises TransportError. `DOMAINS.close` ends that."""
    if domain_id > LARGEST_DOMAIN:
        raise TransportError(
            f'domain {domain_id} has no ports on DDS: set ROS_DOMAIN_ID to at most {LARGEST_DOMAIN}'
        )
    # The name service may be asked, for seconds: so not under the lock, and only where the domain is not
    # open.
    configuration = '' if DOMAINS.get(domain_id) else domain_configuration(domain_id)
    return DOMAINS.open(
        domain_id, lambda: Domain(library, domain_id, configuration or domain_configuration(domain_id))
    )

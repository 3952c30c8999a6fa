"""Domains of the library: one per domain id and process, made by the first session, ended by the last."""

from __future__ import annotations

from threading import Lock

from goalwire.errors import TransportError
from goalwire.transport.dds.abi import Library
from goalwire.transport.dds.configuration import LARGEST_DOMAIN, domain_configuration
from goalwire.transport.dds.reader_dispatcher import LocalReaders
from goalwire.transport.fork import in_child


class Domain:
    """One domain and its sessions in this process."""

    def __init__(self, handle: int) -> None:
        self.handle = handle
        self.users = 0
        self.local_readers = LocalReaders()


class Domains:
    """The domains of this process."""

    def __init__(self) -> None:
        self._reset()
        in_child(self._reset)  # the parent's are dead there, and its lock may have been held

    def _reset(self) -> None:
        self._lock = Lock()
        self._open: dict[int, Domain] = {}

    def acquire(self, library: Library, domain_id: int) -> Domain:
        """Return the domain, made where this is its first session; raises TransportError."""
        if domain_id > LARGEST_DOMAIN:
            raise TransportError(
                f'domain {domain_id} has no ports on DDS: set ROS_DOMAIN_ID to at most {LARGEST_DOMAIN}'
            )
        with self._lock:
            is_open = domain_id in self._open
        configuration = '' if is_open else domain_configuration(domain_id)  # may ask the name service
        with self._lock:
            domain = self._open.get(domain_id)
            if domain is None:
                configuration = configuration or domain_configuration(domain_id)  # it was ended meanwhile
                domain = self._open[domain_id] = Domain(_create(library, domain_id, configuration))
            domain.users += 1
            return domain

    def release(self, library: Library, domain_id: int) -> None:
        """End the domain where this was its last session."""
        with self._lock:
            domain = self._open[domain_id]
            domain.users -= 1
            if not domain.users:
                del self._open[domain_id]
                library.dds_delete(domain.handle)


def _create(library: Library, domain_id: int, configuration: str) -> int:
    handle = library.dds_create_domain(domain_id, configuration.encode())
    if handle < 0:
        raise TransportError(
            f'Cyclone DDS refused the configuration of domain {domain_id} '
            f'({library.dds_strretcode(handle).decode()}): it has written why to standard error; '
            f'check CYCLONEDDS_URI and ROS_STATIC_PEERS'
        )
    return handle


DOMAINS = Domains()

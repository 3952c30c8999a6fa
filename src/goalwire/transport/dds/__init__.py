"""ROS 2 over DDS, as the RMWs for DDS speak it. The code is imported at the first open.

GOALWIRE_DDS chooses the implementation of DDS: `native`, the default, for goalwire's own RTPS, or `cyclone`
for libddsc.
"""

from __future__ import annotations

from functools import partial

from goalwire.errors import TransportError
from goalwire.security import is_asked_for
from goalwire.transport.contract import Session, SessionOptions, Transport
from goalwire.transport.dds.environment import CHOICE, CYCLONE, NATIVE, choose_session


def _refuse_identity(options: SessionOptions) -> None:
    """Raise TransportError if the program has a security identity: on DDS it would run unprotected."""
    if not is_asked_for():
        return
    from goalwire.security.environment import choose_identity

    if choose_identity(options.enclave) is not None:
        raise TransportError(
            'security is asked for, and goalwire has none on DDS: take RMW_IMPLEMENTATION=rmw_zenoh_cpp, '
            'or unset GOALWIRE_SECURITY and ROS_SECURITY_ENABLE'
        )


def _open(identifier: str, options: SessionOptions) -> Session:
    """Join a domain as the environment's variables say. Raises TransportError or ForkedError."""
    _refuse_identity(options)
    # Only the kind of session that is opened is imported: libddsc takes 12 MB.
    if choose_session() == CYCLONE:
        from goalwire.transport.dds.cyclone import session as on_libddsc

        return on_libddsc.open_session(options)
    from goalwire.transport.dds.native import rmw, session

    defaults = {each.identifier: each for each in (rmw.CYCLONE_DDS, rmw.FAST_DDS, rmw.CONNEXT)}
    return session.open_session(options, defaults[identifier])


IDENTIFIERS = ('rmw_fastrtps_cpp', 'rmw_cyclonedds_cpp', 'rmw_connextdds')
"""The RMWs whose defaults and settings a session can take over."""
TRANSPORTS = {name: Transport(name, partial(_open, name)) for name in IDENTIFIERS}
TRANSPORT = TRANSPORTS['rmw_cyclonedds_cpp']

__all__ = ['CHOICE', 'CYCLONE', 'IDENTIFIERS', 'NATIVE', 'TRANSPORT', 'TRANSPORTS', 'choose_session']

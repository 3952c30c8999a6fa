"""The vendor of a participant's DDS, and the RMW that works best with it."""

from __future__ import annotations

from collections import Counter
from threading import Event

from goalwire.rtps.io.session import RtpsSession
from goalwire.rtps.protocol.announcements import ParticipantData
from goalwire.rtps.protocol.discovery import ParticipantListener
from goalwire.rtps.protocol.messages import VENDOR
from goalwire.transport.dds.settings.session import session_settings

_VENDORS = {
    b'\x01\x0f': ('Fast DDS', 'rmw_fastrtps_cpp'),
    b'\x01\x10': ('Cyclone DDS', 'rmw_cyclonedds_cpp'),
    b'\x01\x01': ('Connext', 'rmw_connextdds'),
    VENDOR: ('goalwire', 'rmw_fastrtps_cpp'),
}


def vendor_name(vendor: bytes) -> str:
    """Return the name of a vendor, as users know it, or its number."""
    return _VENDORS[vendor][0] if vendor in _VENDORS else f'vendor 0x{vendor.hex()}'


def rmw_for(vendor: bytes) -> str:
    """Return the best RMW_IMPLEMENTATION to meet participants of a vendor."""
    return _VENDORS[vendor][1] if vendor in _VENDORS else 'rmw_fastrtps_cpp'


class _Counting(ParticipantListener):
    def __init__(self) -> None:
        self.found: dict[bytes, bytes] = {}
        """The vendor of each participant, by GUID prefix."""

    def on_participant(self, participant: ParticipantData) -> None:
        self.found[participant.prefix] = participant.vendor


def look_for_participants(domain_id: int, window_s: float) -> Counter[bytes]:
    """Return how many participants of each vendor announce themselves, or answer, within a while.

    Raises TransportError if no session can be opened.
    """
    listener = _Counting()
    session = RtpsSession(session_settings(domain_id), listener)
    try:
        Event().wait(window_s)
    finally:
        session.close()
    return Counter(listener.found.copy().values())

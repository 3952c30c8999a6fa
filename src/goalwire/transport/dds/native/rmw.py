"""The defaults of the RMWs for DDS, for policies that a program leaves to its RMW.

Sources: rmw_cyclonedds_cpp src/rmw_node.cpp (create_readwrite_qos); rmw_fastrtps_shared_cpp src/qos.cpp with
Fast DDS's DataReaderQos and WriterQos; rmw_connextdds_common src/common/rmw_impl.cpp with Connext's defaults.
"""

from __future__ import annotations

from goalwire.records import record
from goalwire.rules.qos import INFINITE_NS


@record
class RmwDefaults:
    """The defaults of one RMW."""

    identifier: str
    """The RMW's name in RMW_IMPLEMENTATION."""
    lease_s: float
    """Seconds of silence after which others consider a participant dead."""
    blocking_ns: int
    """How long a reliable publisher with KEEP_ALL waits for room."""
    has_reliable_readers: bool
    """True if a subscription with SYSTEM_DEFAULT requests reliable publishers."""


CYCLONE_DDS = RmwDefaults('rmw_cyclonedds_cpp', 10.0, INFINITE_NS, has_reliable_readers=True)
FAST_DDS = RmwDefaults('rmw_fastrtps_cpp', 20.0, 100_000_000, has_reliable_readers=False)
CONNEXT = RmwDefaults('rmw_connextdds', 100.0, 100_000_000, has_reliable_readers=False)

"""How a recorder records, and how a player plays."""

from __future__ import annotations

from goalwire.apps.bag.selection import Selection
from goalwire.records import record
from goalwire.rules.qos import QoS

CACHE_BYTES = 100 * 2**20
"""How many bytes of messages wait for the file at most, as in rosbag2."""


@record
class RecordOptions:
    """The settings of a recorder."""

    cache_bytes: int = CACHE_BYTES
    snapshot: bool = False
    """Whether messages stay in memory until `Recorder.snapshot`."""
    snapshot_s: float = 0.0
    """How many s of messages a snapshot keeps; 0: as many as the cache holds."""
    repeat: tuple[tuple[str, int], ...] = ()
    """Topics whose latest messages each file begins with, besides /tf_static, and how many of a publisher."""
    discovery: bool = True
    """Whether topics that come later are recorded, too."""
    unpublished: bool = False
    """Whether topics are recorded that somebody subscribes to, and nobody publishes yet."""
    ignore_leaves: bool = False
    """Whether topics are left out that nobody subscribes to."""
    qos: tuple[tuple[str, QoS], ...] = ()
    """The QoS to subscribe with, by topic; for other topics it suits the publishers."""
    sim_time: bool = False
    """Whether messages get the node's time, instead of the time at which they came."""
    paused: bool = False


@record
class PlayOptions:
    """How a player plays; times of the bag are in ns, lengths in s."""

    selection: Selection | None = None
    """The topics that are played; None: all."""
    rate: float = 1.0
    start_offset: float = 0.0
    duration: float | None = None
    until: int | None = None
    loop: bool = False
    delay: float = 0.0
    """How long each round waits before it begins."""
    remaps: tuple[tuple[str, str], ...] = ()
    """Other names for topics."""
    qos: tuple[tuple[str, QoS], ...] = ()
    """The QoS to publish with, by topic; for other topics it is the recorded one."""
    clock_hz: float = 0.0
    """How often the bag's time is published on /clock; 0: not at all."""
    clock_topics: frozenset[str] = frozenset()
    """Topics before whose messages the bag's time is published."""
    clock_always: bool = False
    """Whether it is published before every message."""
    paused: bool = False
    requests_from: str = ''
    """The side whose recorded events are sent to the servers as requests, and not published:
    'service_introspection' or 'client_introspection'; '' for none."""
    goals_from: str = ''
    """True to send the goals of actions, too, and to cancel those that were cancelled in the recording."""

"""The settings of recorders and players."""

from __future__ import annotations

from goalwire.apps.bag.selection import Selection
from goalwire.records import record
from goalwire.rules.qos import QoS

CACHE_BYTES = 100 * 2**20
"""The most bytes of messages that wait for the file, as in rosbag2."""


@record
class RecordOptions:
    """The settings of a recorder."""

    cache_bytes: int = CACHE_BYTES
    snapshot: bool = False
    """True to keep messages in memory until `Recorder.snapshot` is called."""
    snapshot_s: float = 0.0
    """How many seconds of messages a snapshot keeps; 0: as many messages as the cache holds."""
    repeat: tuple[tuple[str, int], ...] = ()
    """Topics besides /tf_static whose latest messages begin each file, and the number for each publisher."""
    discovery: bool = True
    """True to record topics that appear later, too."""
    unpublished: bool = False
    """True to record topics that have subscribers but no publisher yet."""
    ignore_leaves: bool = False
    """True to leave out topics without a subscriber."""
    qos: tuple[tuple[str, QoS], ...] = ()
    """The QoS to subscribe with, by topic; other topics use a QoS that suits their publishers."""
    sim_time: bool = False
    """True to store messages with the node's time instead of the time of their arrival."""
    paused: bool = False


@record
class PlayOptions:
    """The settings of a player. Times of the bag are in ns, durations in s."""

    selection: Selection | None = None
    """The topics that are played; None: all."""
    rate: float = 1.0
    start_offset: float = 0.0
    duration: float | None = None
    until: int | None = None
    loop: bool = False
    delay: float = 0.0
    """Seconds to wait before each pass through the bag."""
    remaps: tuple[tuple[str, str], ...] = ()
    """The recorded names of topics, each with the name under which its messages are published."""
    qos: tuple[tuple[str, QoS], ...] = ()
    """The QoS to publish with, by topic; other topics use the recorded QoS."""
    clock_hz: float = 0.0
    """How many times a second the bag's time is published on /clock; 0: never."""
    clock_topics: frozenset[str] = frozenset()
    """The bag's time is published before each message of these topics."""
    clock_always: bool = False
    """True to publish the bag's time before every message."""
    paused: bool = False
    requests_from: str = ''
    """The side whose recorded events are sent to the servers as requests, and not published:
    'service_introspection' or 'client_introspection'; '' for none."""
    goals_from: str = ''
    """True to send the goals of actions, too, and to cancel those that were cancelled in the recording."""

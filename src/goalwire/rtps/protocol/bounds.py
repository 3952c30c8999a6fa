"""How much of each resource a stranger can take from a participant, and why each figure is what it is.

Anybody who reaches a participant's ports can send it anything, under any name. So all that others can make it
keep, compare, send or log has an end here. What is beyond a bound is ignored and counted by its kind.

The figures leave room for a hundred robots with two hundred endpoints each.
"""

from __future__ import annotations

# ---- packets

PACKET_SIZE = 65_507
"""Bytes of a UDP packet on IPv4 at most."""
SET_BITS = 256
"""Numbers that one ACKNACK, GAP or NACK_FRAG can name, by the standard."""
MOST_PARAMETERS = 256
"""Parameters of one list. Real ones have some 30."""
TEXT_SIZE = 4096
"""Bytes of a name or a type. DDS itself allows 255 characters."""
USER_DATA_SIZE = 4096
"""Bytes of user data. ROS 2's have about 120."""
MOST_PARTITIONS = 64
"""Partitions of one endpoint; each is compared with all of another's."""

# ---- participants

MOST_PARTICIPANTS = 4096
"""Participants that have shown to read what is sent to them."""
MOST_STRANGERS = 256
"""Participants that have announced themselves, and have shown nothing more. One more takes the place of the
oldest. So announcements under made-up names cost some 200 KiB, and do not shut out those who are there."""
MOST_LOCATORS = 8
"""Addresses of one participant or endpoint that are remembered: as many as a machine has interfaces."""
LONGEST_LEASE_S = 3600.0
"""How long a silent participant is remembered at most, whatever lease it asks for."""

LEAST_LEASE_S = 0.01
"""The shortest lease of another participant's writer that is watched: each is a timer."""

# ---- endpoints

MOST_ENDPOINTS = 8192
"""Endpoints of one participant: of a process with three hundred nodes."""

# ---- what waits

AHEAD = 8192
"""Samples that one reader holds back of one writer until an earlier one has been repaired."""
AHEAD_SIZE = 32 << 20
"""Bytes of them. Beyond either bound a sample is dropped, and asked for again later."""
EARLY_PACKETS = 32
"""Packets of one participant that are held back since their writer is not known yet."""
EARLY_S = 0.2
"""How long they are. What tells of the writer comes by another port, and usually within a few ms."""

# ---- fragments

SAMPLE_SIZE = 1 << 30
"""Bytes of one sample in fragments."""
UNFINISHED_SIZE = 1 << 30
"""Bytes of all unfinished samples of one participant's writers together."""
MOST_UNFINISHED = 64
"""Unfinished samples of one writer; one more takes the place of the oldest, which can be asked for again."""
LEAST_FRAGMENT = 64
"""Bytes of a fragment that is not the last: each costs some 100 bytes beside what it holds. The standard's
smallest are a packet's size."""

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
MOST_LOCATORS = 32
"""Addresses that one participant or endpoint tells and that are remembered. A machine with containers has
one for each of their networks."""
MOST_ADDRESSES = 64
"""Addresses of one participant that samples are sent to: each costs a packet for each sample."""
LONGEST_LEASE_S = 3600.0
"""How long a silent participant is remembered at most, whatever lease it asks for."""

LEAST_LEASE_S = 0.01
"""The shortest lease of another participant's writer that is watched: each is a timer."""

# ---- endpoints

MOST_ENDPOINTS = 8192
"""Endpoints of one participant: of a process with three hundred nodes."""
ENDPOINTS_SIZE = 128 << 20
"""Bytes in which all other participants together tell of their endpoints. One takes some 500."""

# ---- what waits

AHEAD = 8192
"""Samples that one reader holds back of one writer until an earlier one has been repaired."""
AHEAD_SIZE = 32 << 20
"""Bytes of them. Beyond either bound a sample is dropped, and asked for again later."""
EARLY_PACKETS = 32
"""Packets of one participant that are held back since their writer is not known yet."""
EARLY_SIZE = 8 << 20
"""Bytes of such packets of all participants."""
EARLY_S = 0.2
"""How long they are. What tells of the writer comes by another port, and usually within a few ms."""

# ---- fragments

KEPT_SIZE = 5 << 28
"""Bytes that all readers keep together of samples that are unfinished, or that came too early."""
SAMPLE_SIZE = 1 << 30
"""Bytes of one sample in fragments."""
MOST_UNFINISHED = 64
"""Unfinished samples of one writer; one more takes the place of the oldest, which can be asked for again."""
UNFINISHED_S = 10.0
"""How long an unfinished sample is kept of which nothing more comes. A reliable reader asks for it again."""
LEAST_FRAGMENT = 64
"""Bytes of a fragment that is not the last: each costs some 100 bytes beside what it holds. The standard's
smallest are a packet's size."""

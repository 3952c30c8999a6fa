"""Limits of the resources that others can take from a participant, with the reason for each figure.

Any program that reaches a participant's ports can send any data in any participant's name. So everything that
others can make a participant keep, compare, send or log has a limit here. Data beyond a limit is ignored and
counted by its kind.

The figures leave room for a hundred robots with two hundred endpoints each.
"""

from __future__ import annotations

# ---- packets

PACKET_SIZE = 65_507
"""Bytes of a UDP packet on IPv4 at most."""
SET_BITS = 256
"""How many numbers one ACKNACK, GAP or NACK_FRAG can name, by the standard."""
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
"""Participants that have proved that they read packets at their address."""
MOST_STRANGERS = 256
"""Participants that have announced themselves and proved nothing yet. One more takes the place of the
oldest. So announcements in invented names cost some 200 KiB, and do not exclude real participants."""
MOST_LOCATORS = 32
"""Addresses remembered for one participant or endpoint. A machine with containers has
one for each of their networks."""
MOST_ADDRESSES = 64
"""Addresses of one participant to which samples are sent: each costs a packet for each sample."""
LONGEST_LEASE_S = 3600.0
"""How long a silent participant is remembered at most, whatever lease it asks for."""

LEAST_LEASE_S = 0.01
"""The shortest liveliness lease of a remote writer that is watched: each needs a timer."""

# ---- endpoints

MOST_ENDPOINTS = 8192
"""Endpoints of one participant: enough for a process with three hundred nodes."""
ENDPOINTS_SIZE = 128 << 20
"""Bytes of SEDP data of all other participants together. An endpoint takes some 500."""

# ---- what waits

AHEAD = 8192
"""Samples of one writer that one reader holds back until an earlier one has been repaired."""
AHEAD_SIZE = 32 << 20
"""Bytes of these samples. Beyond either bound a sample is dropped, and requested again later."""
EARLY_PACKETS = 32
"""Packets of one participant that are held back because their writer is not known yet."""
EARLY_SIZE = 8 << 20
"""Bytes of such packets of all participants."""
EARLY_S = 0.2
"""How long such packets are held. News of the writer arrives at another port, usually within a few ms."""

# ---- fragments

KEPT_SIZE = 5 << 28
"""Bytes that all readers together keep of unfinished and early samples."""
SAMPLE_SIZE = 1 << 30
"""Bytes of one sample in fragments."""
MOST_UNFINISHED = 64
"""Unfinished samples of one writer; one more replaces the oldest, which can be requested again."""
UNFINISHED_S = 10.0
"""How long an unfinished sample without new fragments is kept. A reliable reader requests it again."""
LEAST_FRAGMENT = 64
"""The smallest size of a fragment, except the last: each costs some 100 bytes of memory more. The standard's
smallest are a packet's size."""

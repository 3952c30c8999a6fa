"""How much of each resource a peer can take from a session, and why each figure is what it is.

Anybody who reaches a session's port can send it anything, and a router passes on the words of others. So
this module limits all that a peer can make a session keep, compare, open or log. A message beyond a bound is
ignored and counted, by its kind, in the session's `statistics()`: the first is logged, and then each power of
ten. A link is closed only if its own side must have broken the rules; a router's link stays, since others
speak through it.

The figures leave room for a hundred robots with two hundred endpoints each behind one router.
"""

from __future__ import annotations

# ---- keys

KEY_LIMIT = 8192
"""Bytes of a key. The longest of ROS 2, a token with five names of a thousand characters each, has some
5300."""
WILD_SIGNS = 32
"""Asterisks in an expression. ROS 2's have two. To compare a chunk with asterisks costs some 2 µs."""
MOST_WILD = 256
"""Expressions of each kind that one link may declare with asterisks elsewhere than in a '/**' at the end:
each new endpoint is compared with all of them, which takes 10 ms at most. Those with '/**' are found by their
head."""
KEPT_KEY = 512
"""Bytes of a key that is spelt out in each message, up to which its receivers are remembered. A link
remembers 4096 such keys, in 5 MB at most. ROS 2's sessions declare numbers for the keys of their messages."""
ROUTES_LIMIT = 4096
"""Keys whose receivers one link remembers."""
CACHED_PAIR = 1024
"""Characters of two expressions whose comparison is remembered; of a thousand pairs that makes 1 MB."""

# ---- what is declared

DECLARED_LIMIT = 32 << 20
"""Bytes of all that one link declares: of 20,000 endpoints with keys of 300 bytes 11 MB are counted."""
DECLARED_COST = 256
"""Bytes that each declaration counts for beside its key."""
MOST_INTERESTS = 4096
"""Interests that one client may have. rmw_zenoh's have one for each endpoint and kind."""

# ---- gossip

MOST_NODES = 4096
"""Nodes that are remembered from gossip: four times the processes of a hundred robots. Beyond, the oldest to
which there is no link is forgotten."""
MOST_LOCATORS = 8
"""Addresses of one node that are tried: as many as a machine has interfaces."""
MOST_DIALS = 32
"""Nodes of gossip that are dialled, or in their handshake, at one time, others wait for their turn: so many
descriptors at most, of the 1024 that Linux gives a process."""
GOSSIP_CONNECT_S = 3.0
"""How long a connection to an address of gossip may stay unanswered."""
MOST_LOOK_UPS = 4
"""Threads that look up host names of gossip."""

# ---- links

MOST_LINKS = 10_000
"""Links of one session, those in the handshake included; and at most one for every second descriptor that the
process may have, so that programs can still open files."""
MOST_GREETINGS = 128
"""Connections that others have opened and that are in their handshake, as many as the system's backlog. One
more takes the place of the oldest: a handshake takes milliseconds, and whoever needs seconds mostly never
ends it."""
MOST_FAULTS = 100
"""How many different reasons for closing links the log tells apart; numbers in them do not count."""

# ---- what waits to be sent

UNREAD_LIMIT = 64 << 20
"""Bytes of answers that wait for whoever has asked, before an answer waits for room. So a client that reads
nothing does not hold up the others of a service; one that asks on while so much waits loses its link."""
UNREAD_S = 1.0
"""How long an answer waits beyond that, unless PROGRESS bytes were taken meanwhile; then the link is
closed."""
PROGRESS = 1 << 20
"""The bytes that even a slow reader takes within UNREAD_S."""

# ---- messages in pieces

MESSAGE_LIMIT = 1 << 30
"""Bytes of one message in fragments, as Zenoh's own default; and of all unfinished ones of a link
together."""
UNFINISHED_LIMIT = 2 << 30
"""Bytes of the unfinished messages of all links: two of the largest."""
MOST_PIECES = 1 << 22
"""Pieces of one message. Each piece costs some 60 bytes beside its content, even an empty one."""
STALE_S = 30.0
"""How long an unfinished message is kept of which nothing comes: half of rmw_zenoh's lease."""

"""The limits of the resources that a peer can use in a session, and the reason for each figure.

Every process that reaches a session's port can send it any bytes, and a router passes on messages of others.
So this module limits all that a peer can make a session keep, compare, open or log. A message beyond a bound
is ignored and counted by its kind in the session's `statistics()`. The first one is logged, then the tenth,
the hundredth and so on. A link is closed only if its own other side must have broken the protocol. A router's
link stays, since the message may come from another session behind it.

The figures leave room for a hundred robots with two hundred endpoints each behind one router.
"""

from __future__ import annotations

# ---- keys

KEY_LIMIT = 8192
"""Bytes of a key. The longest key of ROS 2, a token with five names of a thousand characters each, has some
5300."""
WILD_SIGNS = 32
"""Asterisks in an expression; ROS 2's keys have two. Comparing a chunk that has asterisks costs some 2 µs."""
MOST_WILD = 256
"""Expressions of each kind that one link may declare with asterisks in other places than a '/**' at the end.
Each new endpoint is compared with all of them, which takes 10 ms at most. Expressions with '/**' at the end
are found by the text before it."""
KEPT_KEY = 512
"""Bytes of the longest key in full whose receivers a link remembers. It remembers 4096 such keys, in 5 MB at
most. ROS 2's sessions declare numbers for their keys, so their messages have no keys in full."""
ROUTES_LIMIT = 4096
"""The number of keys whose receivers one link remembers."""
CACHED_PAIR = 1024
"""The most characters of two expressions whose comparison is remembered; a thousand pairs take 1 MB."""

# ---- what is declared

DECLARED_LIMIT = 32 << 20
"""Bytes of all declarations of one link. 20,000 endpoints with keys of 300 bytes count as 11 MB."""
DECLARED_COST = 256
"""Bytes that are counted for each declaration in addition to its key."""
MOST_INTERESTS = 4096
"""Interests that one client may have. A client of rmw_zenoh has one for each endpoint and kind."""

# ---- gossip

MOST_NODES = 4096
"""Nodes that are remembered from gossip: four times the processes of a hundred robots. A further node
replaces the oldest node without a link."""
MOST_LOCATORS = 8
"""Addresses of one node that are tried: a machine rarely has more interfaces."""
MOST_DIALS = 32
"""Nodes from gossip that are dialled, or in their handshake, at one time; the others wait for their turn.
Each uses one of the 1024 descriptors that Linux allows a process."""
GOSSIP_CONNECT_S = 3.0
"""How long a connection to an address from gossip may stay unanswered."""
MOST_LOOK_UPS = 4
"""The number of threads that look up host names from gossip."""

# ---- links

MOST_LINKS = 10_000
"""Links of one session, including those in the handshake. Links also use at most half of the descriptors that
the process may have, so that programs can still open files."""
MOST_GREETINGS = 128
"""Connections that others have opened and that are in their handshake, as many as the system's backlog. A
further connection replaces the oldest: handshakes take milliseconds, and a peer that needs seconds rarely
completes one."""
HANDSHAKE_S = 10.0
"""How long a handshake may take, as Zenoh's own default. If one with a configured address took too long, the
session gives the next one twice as long, up to the setting `open_timeout`."""
MOST_FAULTS = 100
"""The number of reasons for closing links that the log distinguishes. Numbers within a reason are ignored."""

# ---- what waits to be sent

UNREAD_LIMIT = 64 << 20
"""Bytes of answers that may be queued for the asking side before further answers wait for room. So a client
that does not read its answers does not delay other clients of a service. A client that sends further queries
while more is queued loses its link."""
UNREAD_S = 1.0
"""How long an answer waits for room before the link is closed. The time starts anew if the asking side takes
PROGRESS bytes meanwhile."""
PROGRESS = 1 << 20
"""The bytes that even a slow reader takes within UNREAD_S."""

# ---- messages in pieces

MESSAGE_LIMIT = 1 << 30
"""Bytes of one message in fragments, Zenoh's own default, and of all unfinished messages of a link
together."""
UNFINISHED_LIMIT = 2 << 30
"""Bytes of the unfinished messages of all links: as many as two of the largest messages have."""
MOST_PIECES = 1 << 22
"""Pieces of one message. Each piece costs some 60 bytes in addition to its content, even an empty piece."""
STALE_S = 30.0
"""How long an unfinished message is kept if no more pieces come: half of rmw_zenoh's lease."""

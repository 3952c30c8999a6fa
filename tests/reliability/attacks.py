"""Strangers that take what they can from a node, and what that costs the node and its other clients.

`python tests/reliability/attacks.py [--seconds 20] [NAME …]` prints the table of reliability.md.
`test_strangers.py` runs one round of each attack. Each stranger speaks Zenoh's protocol over a bare socket.
"""

from __future__ import annotations

import argparse
import os
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, time_ns
from typing import NamedTuple, TypeAlias

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent)] if str(HERE.parent) not in sys.path else []

from helpers.isolation import free_port, isolated_env  # noqa: E402
from helpers.patience import PATIENCE  # noqa: E402
from helpers.processes import Program  # noqa: E402
from helpers.programs import programs_in  # noqa: E402
from helpers.zenoh_protocol import Session  # noqa: E402

from goalwire.transport.zenoh.attachment import GID_SIZE, encode  # noqa: E402
from goalwire.zenoh.protocol.bodies import put_body  # noqa: E402
from goalwire.zenoh.protocol.bounds import MOST_WILD, WILD_SIGNS  # noqa: E402
from goalwire.zenoh.protocol.channels import CHANNELS, DATA_CHANNEL, fragment_head  # noqa: E402
from goalwire.zenoh.protocol.declarations import (  # noqa: E402
    About,
    Kind,
    When,
    declare,
    declare_expression,
    interest,
)
from goalwire.zenoh.protocol.link_messages import Role  # noqa: E402
from goalwire.zenoh.protocol.link_state import Node, tell_of  # noqa: E402
from goalwire.zenoh.protocol.network import BLOCK, DEFAULT_QOS, Target, push_head, wire_key  # noqa: E402
from goalwire.zenoh.protocol.primitives import SourceInfo, encode_source, read_id  # noqa: E402
from goalwire.zenoh.protocol.querier import Querier  # noqa: E402

FORGED = b'\0\1\0\0\7\0\0\0forged\0'
"""A std_msgs/msg/String, in CDR."""
PAUSE_S = 0.02
"""Between two looks at the target's process."""
SETTLING_S = 0.3
"""How long the target has to let go of what a stranger that has hung up had taken."""


class Stranger:
    """A session over a bare socket, which reads only until it has been told what there is."""

    def __init__(self, port: int, role: Role = Role.PEER) -> None:
        self.session = Session(os.urandom(15) + b'\1', role)
        self.link, self._wire = self.session.new_link(connects=True)
        self._socket = socket.create_connection(('127.0.0.1', port), timeout=30)
        self.link.start()
        self.flush()
        while not (self.link.is_up and (self.link.peer.knows_all or role is not Role.PEER)):
            self.link.frames.receive(self._socket.recv(65536))
            self.flush()

    def flush(self) -> None:
        """Send what was said."""
        self._socket.sendall(self._wire.take())

    def say(self, *messages: bytes) -> None:
        """Say network messages."""
        for each in messages:
            self.link.outgoing.send(DATA_CHANNEL, each)
        self.flush()

    def say_raw(self, batch: bytes) -> None:
        """Say a message of the link itself."""
        self._socket.sendall(len(batch).to_bytes(2, 'little') + batch)

    def close(self) -> None:
        """Hang up without a word."""
        self._socket.close()


Round: TypeAlias = Callable[[int], None]
"""One turn of an attack on the target that listens on a port; OSError if the target hangs up."""


@contextmanager
def stranger(port: int, role: Role = Role.PEER) -> Iterator[Stranger]:
    """Be linked to the target for a while."""
    one = Stranger(port, role)
    try:
        yield one
    finally:
        one.close()


def declare_wild_keys(port: int) -> None:
    """Interests and subscribers whose keys have thousands of wildcards, and messages on such keys."""
    chunk = '$*a' * 15_000
    with stranger(port, Role.CLIENT) as one:
        for number in range(10):
            key = f'**/{number}{chunk}/**'
            one.say(interest(900 + number, When.FUTURE, About.ALL, key))
            one.say(declare(Kind.SUBSCRIBER, 900 + number, wire_key(key)))
            one.say(push_head(wire_key(key), DEFAULT_QOS) + put_body(b'x'))


def declare_allowed_wild_keys(port: int) -> None:
    """Subscribers and interests whose keys have as many wildcards as are allowed, and more of them."""
    parts = WILD_SIGNS // 2
    with stranger(port, Role.CLIENT) as one:
        for number in range(2 * MOST_WILD):
            key = f'{number}/' + '/'.join(f'a$*b$*{number}' for _ in range(parts))
            one.say(interest(900 + number, When.FUTURE, About.ALL, key))
            one.say(declare(Kind.SUBSCRIBER, 900 + number, wire_key(key)))
        threading.Event().wait(0.3)  # subscriptions are made meanwhile


def declare_huge_keys(port: int) -> None:
    """Keys of a megabyte, in pieces: interests, subscribers, tokens, and messages on such keys."""
    with stranger(port, Role.CLIENT) as one:
        for number in range(4):
            key = f'{number}/' + '$*a' * (1 << 20) + '/**'
            one.say(interest(900 + number, When.FUTURE, About.ALL, key))
            for kind in (Kind.SUBSCRIBER, Kind.TOKEN):
                one.say(declare(kind, 900 + number, wire_key(key)))
            one.say(push_head(wire_key(key), DEFAULT_QOS) + put_body(b'x'))
        threading.Event().wait(0.3)


def declare_long_keys(port: int) -> None:
    """Keys that are all different: numbers for them, messages on them, and tokens."""
    with stranger(port) as one:
        for number in range(1, 400):
            key = f'{number}/{os.urandom(4000).hex()}'
            one.say(declare_expression(number, key), declare(Kind.TOKEN, number, wire_key(key)))
            one.say(push_head(wire_key(key), DEFAULT_QOS) + put_body(b'x'))
            one.say(push_head(wire_key(key * 7), DEFAULT_QOS) + put_body(b'x'))


def declare_bad_tokens(port: int) -> None:
    """Tokens that look like ROS 2's and are not, each different."""
    domain = os.environ['ATTACKED_DOMAIN']
    with stranger(port) as one:
        for number in range(500):
            text = f'@ros2_lv/{domain}/{number}/x/' + 'y' * (number % 7000 + 10)
            one.say(declare(Kind.TOKEN, 900 + number, wire_key(text)))


def gossip(port: int) -> None:
    """Say as a router that there are thousands of nodes; what listens at their addresses says nothing."""
    with socket.create_server(('127.0.0.1', 0), backlog=4096) as mute, stranger(port, Role.ROUTER) as one:
        where = (f'tcp/127.0.0.1:{mute.getsockname()[1]}',)
        for number in range(5000):
            one.say(tell_of(Node(b'\1' + number.to_bytes(3, 'little') + b'\1', Role.PEER, where), number))
        threading.Event().wait(0.5)


def gossip_of_names(port: int) -> None:
    """Say as a router that there are three thousand nodes at names that nobody can look up."""
    with stranger(port, Role.ROUTER) as one:
        for number in range(3000):
            where = (f'tcp/{number}{"x" * 60}:7447',)  # a label of more than 63 letters: no question goes out
            one.say(tell_of(Node(b'\2' + number.to_bytes(3, 'little') + b'\1', Role.PEER, where), number))
        threading.Event().wait(0.5)


def forge_messages(port: int) -> None:
    """Send messages in the name of the other client's publisher, with numbers far ahead of its own."""
    with stranger(int(os.environ['CALLERS_PORT'])) as one:
        address = next(key for _, key, _ in one.link.peer.queryables.all() if '/beat/' in key)
    key, _, rest = address.partition('/@adv/pub/')
    session, entity = rest.split('/')[:2]
    with stranger(port) as one:
        for number in range(100):
            far = 2_000_000_000 + number
            source = encode_source(SourceInfo(read_id(session), int(entity), far))
            beside = encode(far, time_ns(), GID_SIZE, bytes(GID_SIZE))
            one.say(push_head(wire_key(key), DEFAULT_QOS) + put_body(FORGED, beside, None, source))
        threading.Event().wait(0.3)  # who hangs up without having read takes back what was not read yet


def ask_and_never_read(port: int) -> None:
    """Ask for large answers and read none."""
    with stranger(port) as one:
        key = next(key for _, key, _ in one.link.peer.queryables.all() if '/picture/' in key)
        querier = Querier(one.session, key, target=Target.ALL, qos=DEFAULT_QOS | BLOCK)
        for number in range(1, 150):
            beside = encode(number, time_ns(), GID_SIZE, bytes(GID_SIZE))
            querier.ask(b'\0\1\0\0\0', beside, lambda _: None, lambda: None, 60.0)
            one.flush()
        threading.Event().wait(0.5)


def leave_messages_unfinished(port: int) -> None:
    """Send the beginning of a message of 16 MB in each channel, and hang up."""
    with stranger(port) as one:
        terms = one.link.terms
        assert terms is not None
        for at in range(270):
            for channel in range(CHANNELS):
                number = terms.first_sent + 10_000 + at & 0xFFF_FFFF
                head = fragment_head(channel, number, marks_first=not at, more=True)
                one.say_raw(head + bytes(48_000))


def open_bad_links(port: int) -> None:
    """Connect, say something that is not a handshake, and connect again."""
    for number in range(100):
        with socket.create_connection(('127.0.0.1', port), timeout=30) as sock:
            sock.sendall(b'\x02\0\x7f' + bytes((number,)))
            with suppress(ConnectionResetError):
                sock.recv(1)


def say_nothing(port: int) -> None:
    """Open four hundred connections and say nothing."""
    opened: list[socket.socket] = []
    try:
        opened += [socket.create_connection(('127.0.0.1', port), timeout=30) for _ in range(400)]
        threading.Event().wait(0.3)
    finally:
        for each in opened:
            each.close()


ATTACKS: dict[str, Round] = {
    'keys with thousands of wildcards': declare_wild_keys,
    'keys with as many wildcards as are allowed': declare_allowed_wild_keys,
    'keys of 3 MB, of wildcards': declare_huge_keys,
    'long keys, all different': declare_long_keys,
    'tokens that are malformed': declare_bad_tokens,
    'gossip of 5,000 nodes that say nothing': gossip,
    'gossip of 3,000 names': gossip_of_names,
    "messages in the other client's name": forge_messages,
    'questions whose answers are never read': ask_and_never_read,
    'unfinished messages in 16 channels, 200 MB': leave_messages_unfinished,
    'links that break the rules at once': open_bad_links,
    '400 connections that say nothing': say_nothing,
}


def do_nothing(_port: int) -> None:
    """Wait for a second; the attacks are compared with this."""
    threading.Event().wait(1.0)


class Use(NamedTuple):
    """The resources of the target's process."""

    memory: float
    """MiB."""
    descriptors: int
    threads: int


def use_of(pid: int) -> Use:
    """Look at a process."""
    status = Path(f'/proc/{pid}/status').read_text(encoding='ascii', errors='replace')
    found = dict(line.split(':', 1) for line in status.splitlines())
    memory = int(found['VmRSS'].split()[0]) / 1024
    return Use(memory, len(os.listdir(f'/proc/{pid}/fd')), int(found['Threads']))  # noqa: PTH208


class Figures(NamedTuple):
    """The cost of one attack."""

    before: Use
    most: Use
    after: Use
    rounds: int
    calls: int
    """The other client's, during the attack."""
    p99_ms: float
    longest_ms: float
    wrong: int
    missed: int
    """Messages of the other client, on a latched topic, that the target did not get."""
    lines: int
    """Lines that the target has logged."""


class World:
    """A target, a client of it, and strangers."""

    def __init__(self, target: Program, caller: Program, port: int) -> None:
        self.target, self.caller, self.port = target, caller, port
        self._calls()

    def _calls(self) -> tuple[int, float, float, int, int]:
        self.caller.write_line('figures')
        found = self.caller.expect(r'figures (\d+) ([\d.]+) ([\d.]+) ([\d.]+) (\d+) (\d+)', 2 * PATIENCE)
        return int(found[1]), float(found[3]), float(found[4]), int(found[5]), int(found[6])

    def attack(self, attack: Round, seconds: float) -> Figures:
        """Attack for a while, again and again, and look at the target meanwhile."""
        lines = len(self.target.output.splitlines())
        before = use_of(self.target.pid)
        looks = [before]
        over = threading.Event()

        def look() -> None:
            while not over.wait(PAUSE_S):
                looks.append(use_of(self.target.pid))

        watcher = threading.Thread(target=look)
        watcher.start()
        self._calls()
        end, rounds = monotonic() + seconds, 0
        try:
            while not rounds or monotonic() < end:
                with suppress(OSError):  # it hung up, as it should
                    attack(self.port)
                rounds += 1
        finally:
            calls, p99, longest, wrong, missed = self._calls()
            last = monotonic() + PATIENCE
            while not calls and monotonic() < last:  # the attack was shorter than a call
                calls, p99, longest, wrong, missed = self._calls()
            over.wait(SETTLING_S)
            over.set()
            watcher.join()
        most = Use(*(max(each) for each in zip(*looks, strict=True)))
        after, told = use_of(self.target.pid), len(self.target.output.splitlines()) - lines
        return Figures(before, most, after, rounds, calls, p99, longest, wrong, missed, told)


@contextmanager
def attacked_world() -> Iterator[World]:
    """Start a target and its client."""
    port, callers_port = free_port(), free_port()
    env = isolated_env('rmw_zenoh_cpp')
    os.environ['ATTACKED_DOMAIN'], os.environ['CALLERS_PORT'] = env['ROS_DOMAIN_ID'], str(callers_port)
    listen = 'listen/endpoints=["tcp/127.0.0.1:{}"]'
    with programs_in(env, HERE / 'programs') as start:
        target = start('target', ZENOH_CONFIG_OVERRIDE=listen.format(port))
        target.expect('ready')
        caller = start('caller', ZENOH_CONFIG_OVERRIDE=listen.format(callers_port))
        caller.expect('ready')
        yield World(target, caller, port)


def rows(names: list[str], seconds: float) -> Iterator[str]:
    """Yield the table."""
    yield (
        '| what a stranger does | rounds | memory before, most, after, MiB | descriptors | threads | lines '
        '| calls and messages lost | p99 and longest call of others, ms |'
    )
    yield '|---|---|---|---|---|---|---|---|'
    with attacked_world() as world:
        for name in ['nothing', *names]:
            found = world.attack(ATTACKS.get(name, do_nothing), seconds)
            before, most, after = found.before, found.most, found.after
            yield (
                f'| {name} | {found.rounds} | {before.memory:.0f}, {most.memory:.0f}, {after.memory:.0f} '
                f'| {before.descriptors} → {most.descriptors} | {before.threads} → {most.threads} '
                f'| {found.lines} | {found.wrong + found.missed} '
                f'| {found.p99_ms:.0f}, {found.longest_ms:.0f} |'
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=float, default=20.0, help='how long each attack goes on')
    parser.add_argument('names', nargs='*', metavar='NAME', help=', '.join(ATTACKS))
    chosen = parser.parse_args()
    for row in rows(chosen.names or list(ATTACKS), chosen.seconds):
        sys.stdout.write(row + '\n')
        sys.stdout.flush()


if __name__ == '__main__':
    main()

"""Attacks on a protected robot: each verb, tried by each kind of identity, on each way to the robot.

`python tests/security/attacks.py` makes all attempts and prints how they ended. `test_attacks.py` runs a few
of them in every run of the tests, and all of them with `make long`. What must come of an attempt is asked of
the policy, as `goalwire secure explain` asks it; the policies are drawn by chance.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from random import Random
from typing import NamedTuple

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent)] if str(HERE.parent) not in sys.path else []

from helpers.secured_site import (  # noqa: E402
    FEEDBACK,
    MARKER,
    OPEN,
    SERVICES,
    STRANGERS,
    TOPIC,
    Robot,
    Site,
    exchange,
    files_of,
    node_token,
    opened,
    policy_of,
)
from helpers.zenoh_sides import Ours, Side, Theirs  # noqa: E402

from goalwire.security.keystore import Keystore  # noqa: E402
from goalwire.security.policy import Policy, Verb  # noqa: E402
from goalwire.security.policy_file import load_policy  # noqa: E402
from goalwire.transport.zenoh.router_rules import inexpressible  # noqa: E402
from goalwire.zenoh.io.endpoints import TlsFiles  # noqa: E402

NAME = '/secret'
NOBODYS = '0/nobody/serves/this'
FORGED = b'from a stranger'
ASKING_S = 5.0
"""How long a query waits. Those that are refused or not understood are answered at once."""


class Way(NamedTuple):
    """How the attacker comes to the robot."""

    title: str
    make: type[Ours | Theirs]
    mode: str
    has_router: bool = False


WAYS = (
    Way('goalwire peer', Ours, 'peer'),
    Way('stock peer', Theirs, 'peer'),
    Way('stock client', Theirs, 'client'),
    Way('stock client of a router', Theirs, 'client', has_router=True),
)
AS_ROUTER = Way('stock router', Theirs, 'router')
"""A router passes on what others say, so it needs a certificate of the kind `router`."""


# ---- what is tried: each returns whether it succeeded


def _publishes(attacker: Side, robot: Side) -> bool:
    return TOPIC in exchange(attacker, robot, TOPIC, last=MARKER)


def _hears(key: str) -> Callable[[Side, Side], bool]:
    return lambda attacker, robot: key in exchange(robot, attacker, key, last=OPEN)


def _asks(key: str) -> Callable[[Side, Side], bool]:
    def ask(attacker: Side, robot: Side) -> bool:
        robot.serve(key, b'done')
        exchange(robot, attacker, last=OPEN)  # the attacker knows of the service by now, if it may
        answers = attacker.ask(key, timeout_s=ASKING_S).wait()
        return any(payload.startswith(b'done') for _, payload in answers)

    return ask


def _serves(attacker: Side, robot: Side) -> bool:
    attacker.serve(SERVICES[Verb.CALL], b'false')
    exchange(attacker, robot, last=MARKER)
    answers = robot.ask(SERVICES[Verb.CALL], timeout_s=ASKING_S).wait()
    return any(payload.startswith(b'false') for _, payload in answers)


def _runs(attacker: Side, robot: Side) -> bool:
    attacker.token(node_token(attacker.id))
    exchange(attacker, robot, last=MARKER)
    return node_token(attacker.id) in robot.present('@ros2_lv/**')


def _looks(attacker: Side, robot: Side) -> bool:
    robot.token(node_token(robot.id))
    exchange(robot, attacker, last=OPEN)
    return node_token(robot.id) in attacker.present('@ros2_lv/**')


ATTEMPTS: dict[Verb, Callable[[Side, Side], bool]] = {
    Verb.SERVE: _serves,  # before the robot serves the same
    Verb.RUN: _runs,
    Verb.PUBLISH: _publishes,
    Verb.SUBSCRIBE: _hears(TOPIC),
    **{verb: _asks(key) for verb, key in SERVICES.items()},
    Verb.WATCH: _hears(FEEDBACK),
    Verb.INTROSPECT: _looks,
}


def says(policy: Policy, verb: Verb, *, has_router: bool) -> bool:
    """Whether mallory may do something to NAME, by the policy, or by all that a router can express of it."""
    verbs = {verb, Verb.SEND} if verb is Verb.WATCH else {verb}
    is_allowed = any(policy.decide('mallory', each, NAME).is_allowed for each in verbs)
    if not has_router:
        return is_allowed
    told = inexpressible(policy)
    is_refused = any(each.startswith(f"a router refuses 'mallory' to {verb.value} by") for each in told)
    is_wider = any(each.startswith(f"a router lets 'mallory' {verb.value} more") for each in told)
    return (is_allowed and not (is_refused and verb in SERVICES)) or is_wider


# ---- policies drawn by chance

_FITTING = ('/secret', '/sec*', '/*', '/**', '/secret/**')
_OTHERS = ('/other', '/secret/below', '/secrets', '/*/secret', '/a/**')


def draw_policy(random: Random) -> str:
    """Return a policy by which mallory may do some things to NAME, and others to other names only."""
    grants: dict[Verb, list[str]] = {}
    for verb in Verb:
        patterns = random.sample(_OTHERS, random.randrange(3))
        if random.random() < 0.5:
            patterns.append(random.choice(_FITTING))
        if patterns:
            grants[verb] = random.sample(patterns, len(patterns))
    return policy_of(grants)


# ---- who tries it


def make_keystore(folder: Path) -> Keystore:
    """Return a new keystore with all identities."""
    keystore = Keystore.create(folder / 'keys')
    for name, kind in (('site', 'router'), ('robby', 'robot'), ('ann', 'robot'), ('mallory', 'program')):
        keystore.add(name, kind, ())
    return keystore


class Ended(NamedTuple):
    """How one attempt ended, and whether it had to succeed."""

    verb: Verb
    succeeded: bool
    should: bool


def try_as_mallory(folder: Path, way: Way, seed: int) -> list[Ended]:
    """Try each verb with a right certificate: the policy, which is drawn from `seed`, decides."""
    with ExitStack() as stack:
        site = Site(make_keystore(folder), draw_policy(Random(seed)), stack)
        policy = load_policy(site.keystore.policy_path)
        where = site.router() if way.has_router else site.robot.where
        files = files_of(site.keystore, 'mallory')
        with opened(lambda: way.make(way.mode, connect=(where,), tls=files)) as attacker:
            assert attacker is not None, 'mallory gets no link'
            return [
                Ended(verb, attempt(attacker, site.robot), says(policy, verb, has_router=way.has_router))
                for verb, attempt in ATTEMPTS.items()
            ]


def try_as_stranger(folder: Path, way: Way, who: str) -> list[Ended]:
    """Try each verb as somebody who may do nothing, though mallory may do all: each attempt must fail."""
    keystore = make_keystore(folder)
    files = STRANGERS[who](keystore) if who in STRANGERS else files_of(keystore, 'mallory')
    with ExitStack() as stack:
        site = Site(keystore, policy_of({verb: ['/**'] for verb in Verb}), stack)
        where = site.router() if way.has_router else site.robot.where
        honest = site.keep(Robot(site.keystore, 'ann', (where,)))
        zid = honest.id if who == ANOTHERS_ID else ''
        if who == WITHOUT_TLS:
            where, files = where.replace('tls/', 'tcp/'), TlsFiles()
        with opened(lambda: way.make(way.mode, connect=(where,), tls=files, zid=zid)) as attacker:
            return [
                Ended(verb, attacker is not None and _slips_in(verb, attacker, site.robot, honest), False)
                for verb in ATTEMPTS
            ]


WITHOUT_TLS, ANOTHERS_ID = 'without TLS', "with the id of another's session"
NO_ROUTER = 'with the certificate of no router'
STRANGE = [
    *((who, way) for way in (*WAYS, AS_ROUTER) for who in (*STRANGERS, WITHOUT_TLS, ANOTHERS_ID)),
    (NO_ROUTER, AS_ROUTER),
]
"""Pairs of a stranger and a way on which it tries, though it may do nothing there."""


def _slips_in(verb: Verb, attacker: Side, robot: Robot, honest: Side) -> bool:
    """Try a verb. Nothing of it is under way any more once an honest session was served the same way."""
    heard = [attacker.subscribe(key) for key in (TOPIC, FEEDBACK)]
    taken = robot.subscribe(TOPIC)
    attacker.put(TOPIC, FORGED)  # which it hears itself
    attacker.token(node_token(attacker.id))
    robot.token(node_token(robot.id))
    if verb in SERVICES:
        robot.serve(SERVICES[verb], b'done')
    if verb is Verb.SERVE:
        attacker.serve(SERVICES[Verb.CALL], b'false')
    exchange(robot, honest, TOPIC, FEEDBACK, last=OPEN)
    answers = attacker.ask(SERVICES.get(verb, NOBODYS), timeout_s=ASKING_S).wait()
    exchange(honest, robot, last=MARKER)
    served = robot.ask(SERVICES[Verb.CALL], timeout_s=ASKING_S).wait() if verb is Verb.SERVE else []
    return {
        Verb.PUBLISH: FORGED in {payload for _, payload in taken.samples},
        Verb.SUBSCRIBE: {payload for _, payload in heard[0].samples} > {FORGED},
        Verb.WATCH: bool(heard[1].samples),
        Verb.SERVE: any((payload or b'').startswith(b'false') for _, payload in served),
        Verb.RUN: robot.present('@ros2_lv/**') != {node_token(robot.id)},
        Verb.INTROSPECT: node_token(robot.id) in attacker.present('@ros2_lv/**'),
    }.get(verb, any(payload.startswith(b'done') for _, payload in answers))


# ---- the table


class Row(NamedTuple):
    """An identity on a way, and how its attempts ended."""

    who: str
    way: Way
    ended: list[Ended]


def run(policies: int, seed: int) -> Iterator[Row]:
    """Make all attempts: by mallory under so many policies, and by each kind of stranger."""
    for way in WAYS:
        with tempfile.TemporaryDirectory() as folder:
            ended: list[Ended] = []
            for number in range(policies):
                ended += try_as_mallory(Path(folder, str(number)), way, seed + number)
            for who, should in (('a right certificate, allowed', True), ('not allowed', False)):
                yield Row(who, way, [each for each in ended if each.should is should])
    for who, way in STRANGE:
        with tempfile.TemporaryDirectory() as folder:
            yield Row(who, way, try_as_stranger(Path(folder), way, who))


def show(rows: Iterator[Row]) -> bool:
    """Print a line for each row; return whether all attempts ended as they had to."""
    print(f'{"who":36}{"way":30}{"attempts":>9}{"succeeded":>10}{"wrong":>6}')  # noqa: T201
    is_right = True
    for who, way, ended in rows:
        count = Counter((each.succeeded, each.should) for each in ended)
        succeeded = sum(number for (is_so, _), number in count.items() if is_so)
        wrong = sum(number for (is_so, should), number in count.items() if is_so is not should)
        is_right &= not wrong
        print(f'{who:36}{way.title:30}{len(ended):9}{succeeded:10}{wrong:6}', flush=True)  # noqa: T201
    return is_right


def main() -> None:
    """Run all attempts and print the table."""
    parser = argparse.ArgumentParser(description='Attack a protected robot; print how that ended.')
    parser.add_argument('--policies', type=int, default=10, help='Policies for each way (default: 10)')
    parser.add_argument('--seed', type=int, default=0, help='Where the policies begin (default: 0)')
    arguments = parser.parse_args()
    raise SystemExit(0 if show(run(arguments.policies, arguments.seed)) else 1)


if __name__ == '__main__':
    main()

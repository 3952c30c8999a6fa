"""The settings of a fleet's routers: robots dial sites, sites dial a cloud, and each link has mutual TLS.

    robot's router --tls--> site's router --tls--> cloud's router <--tls-- operators

Zenoh's routers pass on everything to each other, tokens too. So without rules each robot would learn of all
others. The router of a site therefore shows a robot only what is about the robot's own namespace, and the
router of a robot neither sends nor takes anything else. Both know the other side by its certificate.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from goalwire.records import record
from goalwire.transport.zenoh.ros_keys import GRAPH_SPACE
from goalwire.transport.zenoh.settings import built_in
from goalwire.transport.zenoh.settings.values import Configuration, Json, Settings

if TYPE_CHECKING:
    from goalwire.security.environment import Chosen

_DATA = ('put', 'delete', 'reply', 'query', 'declare_subscriber', 'declare_queryable')
_TOKEN = ('liveliness_token',)
_WATCHING = ('declare_liveliness_subscriber', 'liveliness_query')
_IN, _OUT = 'ingress', 'egress'
_EVERYTHING = ('**', f'{GRAPH_SPACE}/**', '**/@adv/**')
LEASE_MS = 10_000
"""Milliseconds of silence after which a router counts as gone: radio links fail without any message."""

MOST_KEYS = 65_535
"""The keys that a link between two routers carries at most, in both directions together: Zenoh numbers them
with 16 bits. With more keys eclipse-zenoh's router (1.10.2) searches for a free number for ever."""
KEYS_OF_A_HUMANOID = 110
"""The keys of a robot with all of the humanoid's names, counted on the wire."""


@record
class Uplink:
    """The data that a robot sends to its site."""

    allow: tuple[str, ...] = ()
    """The names that may leave the robot, below its namespace; empty: all of them."""
    rates: Mapping[str, float] | None = None
    """The highest rate in Hz of some topics."""
    background: tuple[str, ...] = ()
    """Topics that give way to everything else, and are dropped when the link is full."""


def site_router(
    identity: Chosen,
    listen: Sequence[str],
    connect: Sequence[str],
    robots: Iterable[str],
    others: Iterable[str],
) -> Settings:
    """Return the settings of the router of a site or a cloud.

    It listens at `listen` and dials the routers in `connect`. `robots` and `others` are the names of the
    certificates that may connect: each robot with its own namespace only, the others with everything.
    """
    config = _router(identity, listen, connect)
    names = list(robots)
    rules = [rule for robot in names for rule in _rules(robot, to_robot=_OUT, from_robot=_IN)]
    policies: list[Json] = [{'rules': _ids(robot), 'subjects': [robot]} for robot in names]
    subjects: list[Json] = [{'id': robot, 'cert_common_names': [robot]} for robot in names]
    rules += _everything()
    subjects.append({'id': 'others', 'cert_common_names': list(others)})
    policies.append({'rules': ['everything', 'everything seen'], 'subjects': ['others']})
    config.set('access_control', _access(rules, subjects, policies))
    return config.values


def robot_router(identity: Chosen, robot: str, port: int, connect: Sequence[str], uplink: Uplink) -> Settings:
    """Return the settings of a robot's own router: its programs meet at `port`, and it dials `connect`."""
    config = _router(identity, [f'tcp/127.0.0.1:{port}'], connect)
    rules = _rules(robot, to_robot=_IN, from_robot=_OUT, allow=uplink.allow) + _everything()
    subjects: list[Json] = [
        {'id': 'uplink', 'link_protocols': ['tls']},
        {'id': 'programs', 'link_protocols': ['tcp']},
    ]
    policies: list[Json] = [
        {'rules': _ids(robot), 'subjects': ['uplink']},
        {'rules': ['everything', 'everything seen'], 'subjects': ['programs']},
    ]
    config.set('access_control', _access(rules, subjects, policies))
    if uplink.rates:
        config.set(
            'downsampling',
            [
                {
                    'messages': ['put'],
                    'flows': [_OUT],
                    'link_protocols': ['tls'],
                    'rules': [
                        {'key_expr': key, 'freq': rate}
                        for name, rate in uplink.rates.items()
                        for key in _keys_of(robot, [name])[:1]
                    ],
                }
            ],
        )
    if uplink.background:
        config.set(
            'qos/network',
            [
                {
                    'messages': ['put'],
                    'flows': [_OUT],
                    'link_protocols': ['tls'],
                    'key_exprs': list(_keys_of(robot, uplink.background)),
                    'overwrite': {'priority': 'background', 'congestion_control': 'drop'},
                }
            ],
        )
    return config.values


def _router(identity: Chosen, listen: Sequence[str], connect: Sequence[str]) -> Configuration:
    config = Configuration(built_in.rendezvous(0))
    config.set('listen/endpoints', list(listen))
    config.set('connect/endpoints', list(connect))
    config.set('transport/link/tls', built_in.tls_of_identity(identity))
    config.set('transport/link/tls/close_link_on_expiration', True)
    config.set('transport/link/tx/lease', LEASE_MS)
    return config


def _access(rules: Sequence[Json], subjects: list[Json], policies: list[Json]) -> Settings:
    return {
        'enabled': True,
        'default_permission': 'deny',
        'rules': list(rules),
        'subjects': subjects,
        'policies': policies,
    }


def _rule(name: str, flows: Sequence[str], messages: Sequence[str], keys: Sequence[str]) -> Json:
    return {
        'id': name,
        'permission': 'allow',
        'flows': list(flows),
        'messages': list(messages),
        'key_exprs': list(keys),
    }


def _everything() -> list[Json]:
    return [
        _rule('everything', (_IN, _OUT), _DATA, _EVERYTHING),
        _rule('everything seen', (_IN, _OUT), (*_TOKEN, *_WATCHING), _EVERYTHING),
    ]


_PARTS = ('calls', 'data', 'shows', 'sees', 'asks')


def _ids(robot: str) -> list[Json]:
    return [f'{robot} {part}' for part in _PARTS]


def _rules(robot: str, *, to_robot: str, from_robot: str, allow: Sequence[str] = ()) -> list[Json]:
    """Return the rules of the link between a robot and its site, as `_ids` names them."""
    names = allow or ('**',)
    keys = _keys_of(robot, names)
    both = (_IN, _OUT)
    return [
        _rule(f'{robot} calls', (to_robot,), _DATA, _keys_of(robot, ('**',))),
        _rule(f'{robot} data', (from_robot,), _DATA, keys),
        _rule(f'{robot} shows', (from_robot,), _TOKEN, [*_tokens_of(robot, allow), *keys]),
        _rule(f'{robot} sees', (to_robot,), _TOKEN, [*_tokens_about(robot, ('**',)), *keys]),
        _rule(f'{robot} asks', both, _WATCHING, _EVERYTHING),
    ]


def _keys_of(robot: str, names: Iterable[str]) -> list[str]:
    """Return the key expressions of topics, services and actions on a robot, and of their histories."""
    found: list[str] = []
    for name in names:
        path = '**' if name == '**' else f'{_wild(name)}/**'
        found += [f'*/{robot}/{path}', f'*/{robot}/{path}/@adv/**']
    return found


def _tokens_of(robot: str, allow: Sequence[str]) -> list[str]:
    """Return the key expressions of the tokens that a robot shows: its nodes, and what may leave it."""
    spaces = (f'%{robot}', f'%{robot}%$*')
    if not allow:
        return [f'{GRAPH_SPACE}/*/*/*/*/*/*/{space}/**' for space in spaces]
    return [f'{GRAPH_SPACE}/*/*/*/*/NN/*/{space}/**' for space in spaces] + _tokens_about(robot, allow)


def _tokens_about(robot: str, names: Iterable[str]) -> list[str]:
    """Return the key expressions of the tokens of endpoints on a robot's names, in any session."""
    found: list[str] = []
    for name in names:
        if name == '**':
            found.append(f'{GRAPH_SPACE}/*/*/*/*/*/*/*/*/%{robot}%$*/**')
            continue
        mangled = f'%{robot}%{name.replace("*", "$*").replace("/", "%")}'
        found += [f'{GRAPH_SPACE}/*/*/*/*/*/*/*/*/{each}/**' for each in (mangled, f'{mangled}%$*')]
    return found


def _wild(name: str) -> str:
    """Return a pattern of names as Zenoh writes it: '*' within a part is '$*'."""
    return '/'.join(part if part == '*' else part.replace('*', '$*') for part in name.split('/'))

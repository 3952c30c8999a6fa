"""The table of what a configuration may hold, compared with the installed eclipse-zenoh's."""

from __future__ import annotations

import json

import pytest
import zenoh

from goalwire.transport.zenoh.settings import built_in, schema
from goalwire.transport.zenoh.settings.values import Json


def test_each_name_of_the_installed_zenoh_is_known() -> None:
    values = json.loads(str(zenoh.Config()))
    assert list(schema.unknown(values)) == []
    assert list(schema.faults(values)) == []


VALUES: list[Json] = [
    7,
    'x',
    'ab12',
    '0a',
    'AB',
    'peer',
    'always',
    '32bit',
    True,
    {},
    {'peer': True},
    {'peer': 7},
    {'peer': ['tcp/[::]:0']},
    {'x': 1},
    ['router'],
    ['tcp/[::]:0'],
    ['x'],
    [7],
]


def takes(path: str, value: Json) -> bool:
    """Whether eclipse-zenoh takes a value."""
    try:
        zenoh.Config().insert_json5(path, json.dumps(value))
    except zenoh.ZError:
        return False
    return True


@pytest.mark.parametrize(
    'path',
    [
        'id',
        'mode',
        'connect/endpoints',
        'connect/timeout_ms',
        'listen/exit_on_failure',
        'scouting/delay',
        'scouting/multicast/enabled',
        'scouting/multicast/listen',
        'scouting/gossip/target',
        'scouting/gossip/autoconnect_strategy',
        'timestamping/enabled',
        'queries_default_timeout',
        'transport/link/tx/lease',
        'transport/link/tx/sequence_number_resolution',
        'transport/link/tx/queue/size/data',
        'transport/link/tls/root_ca_certificate',
        'transport/unicast/qos/enabled',
        'transport/shared_memory/transport_optimization/pool_size',
    ],
)
def test_values_are_judged_as_zenoh_judges_them(path: str) -> None:
    known = schema.find(path)
    assert known is not None
    judged = [
        not [*schema.faults(value, path, known), *schema.unknown(value, path, known)] for value in VALUES
    ]
    theirs = [takes(path, value) for value in VALUES]
    assert dict(zip(map(str, VALUES), judged, strict=True)) == dict(
        zip(map(str, VALUES), theirs, strict=True)
    )


def test_names_that_are_not_known_are_told_apart_from_values_that_do_not_fit() -> None:
    values: Json = {
        'mode': 'pear',
        'scouting': {'delayed': 1},
        'later': {'x': 1},
        'plugins': {'any': {'thing': 1}},
    }
    assert [fault.path for fault in schema.faults(values)] == ['mode']
    assert list(schema.unknown(values)) == ['scouting/delayed', 'later']
    assert schema.find('plugins/any/a') is not None


@pytest.mark.parametrize('values', [built_in.session(7447), built_in.rendezvous(7447)])
def test_the_built_in_settings_fit(values: Json) -> None:
    assert list(schema.faults(values)) == []
    assert list(schema.unknown(values)) == []


def test_what_may_differ_by_mode_does() -> None:
    assert schema.of_mode({'router': 1, 'peer': 2}, 'peer') == 2
    assert schema.of_mode({'router': 1}, 'peer') is None
    assert schema.of_mode({'other': 1}, 'peer') == {'other': 1}
    assert schema.of_mode([1], 'peer') == [1]

"""The parameters of other nodes, and what a form takes for one."""

from __future__ import annotations

import asyncio

import pytest
from helpers.patience import PATIENCE

import goalwire
from goalwire.errors import FieldValueError
from goalwire.observe.parameters import (
    NodeParameters,
    RemoteParameter,
    fit_typed_value,
    kind_name,
    nodes_with_parameters,
)

BOOL, INTEGER, DOUBLE, STRING, BYTES, INTEGERS = 1, 2, 3, 4, 5, 7


@pytest.mark.parametrize(
    ('number', 'typed', 'value'),
    [
        (BOOL, True, True),
        (INTEGER, '4', 4),
        (DOUBLE, '2', 2.0),
        (STRING, '[a', '[a'),
        (STRING, '[1, 2]', '[1, 2]'),
        (STRING, None, ''),
        (BYTES, '[1, 255]', [b'\x01', b'\xff']),
        (INTEGERS, '[1, 2]', [1, 2]),
    ],
)
def test_what_fits_is_taken(number: int, typed: object, value: object) -> None:
    assert fit_typed_value(RemoteParameter('p', number, None), typed) == value


@pytest.mark.parametrize(
    ('number', 'typed', 'problem'),
    [
        (INTEGER, '2.5', 'p: give a whole number such as 3, not 2.5 (integer)'),
        (INTEGER, None, 'p: give a whole number such as 3, not null (integer)'),
        (DOUBLE, 'fast', "p: give a number such as 1.5, not 'fast' (double)"),
        (DOUBLE, '.nan', 'p: give a number from 0 to 1, not nan (double)'),
        (DOUBLE, '2', 'p: give a number from 0 to 1, not 2 (double)'),
        (INTEGERS, '1, 2', "p: give a list such as [1, 1], not '1, 2' (integer array)"),
        (BYTES, '[256]', 'p[0]: give a number from 0 to 255, not 256 (byte array)'),
        (INTEGERS, '[', 'p: that is not YAML: '),
        (0, '1', 'p: it is not set, and so has no type'),
    ],
)
def test_what_does_not_fit_is_refused_with_an_example(number: int, typed: object, problem: str) -> None:
    with pytest.raises(FieldValueError) as caught:
        fit_typed_value(RemoteParameter('p', number, None, least=0.0, most=1.0), typed)
    assert str(caught.value).startswith(problem)


def test_a_node_is_asked_for_what_it_has_and_told_to_change_it(isolated: dict[str, str]) -> None:
    from rcl_interfaces.msg import ParameterValue

    async def play() -> None:
        async with goalwire.Node('robot') as robot, goalwire.Node('asking') as node:
            robot.parameters.declare('speed', 1.5)
            robot.parameters.declare('arm.reach', 'far')
            robot.parameters.declare('ports', [b'\x01', b'\xff'])
            with NodeParameters(node, '/robot', PATIENCE) as parameters:
                names = await parameters.names()
                assert {'speed', 'ports'} <= set(names)
                assert await parameters.names(['arm']) == ['arm.reach']
                assert list(await parameters.values(['speed', 'nothing'])) == ['speed']
                assert list(await parameters.descriptors(['speed', 'nothing'])) == ['speed']
                found = {each.name: each for each in await parameters.read()}
                assert (found['speed'].kind, found['speed'].value) == ('double', 1.5)
                assert (found['ports'].kind, found['ports'].value) == ('byte array', [1, 255])
                [(name, result)] = await parameters.set([('speed', ParameterValue(type=3, double_value=2.5))])
                assert (name, result.successful, robot.parameters['speed']) == ('speed', True, 2.5)
            assert '/robot' in nodes_with_parameters(node.graph.served())

    asyncio.run(asyncio.wait_for(play(), 3 * PATIENCE))


def test_kinds_have_the_names_of_ros2_param() -> None:
    assert [kind_name(number) for number in (0, 1, 9, 10)] == [
        'not set',
        'boolean',
        'string array',
        'unknown (10)',
    ]

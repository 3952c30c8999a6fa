"""A node's parameters as a mapping."""

from __future__ import annotations

import asyncio

import pytest
from helpers.loops import Play
from helpers.patience import PATIENCE
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters

import goalwire
from goalwire.errors import (
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterNotDeclaredException,
)


def positive(value: float) -> None:
    if value <= 0:
        raise ValueError('must be above 0')


def test_parameters_are_declared_read_and_set(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node', parameters={'speed': 2.0}) as node:
            parameters = node.parameters
            assert parameters.declare('speed', 1.0) == 2.0
            assert parameters.declare('name', 'robbie') == 'robbie'
            parameters['name'] = 'marvin'
            assert (parameters['name'], 'name' in parameters, 'age' in parameters) == ('marvin', True, False)
            assert {'speed', 'name', 'use_sim_time'} <= set(parameters)
            assert len(parameters) == len(list(parameters))
            parameters.update({'speed': 3.0, 'name': 'bender'})
            assert (parameters['speed'], parameters['name']) == (3.0, 'bender')
            with pytest.raises(KeyError, match='age'):
                parameters['age']
            with pytest.raises(ParameterNotDeclaredException):
                parameters['age'] = 3
            with pytest.raises(ParameterAlreadyDeclaredException):
                parameters.declare('name', 'again')

    play(scenario)


def test_arguments_of_the_node_override_declarations(play: Play) -> None:
    async def scenario() -> None:
        arguments = ['--ros-args', '-p', 'speed:=4.5', '-r', '__node:=renamed']
        async with goalwire.Node('node', arguments=arguments) as node:
            assert node.name == '/renamed'
            assert node.parameters.declare('speed', 1.0) == 4.5

    play(scenario)


def test_a_check_refuses_values_whoever_sets_them(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node, goalwire.Node('other') as other:
            parameters = node.parameters
            parameters.declare('speed', 1.0, check=positive)
            with pytest.raises(InvalidParameterValueException, match='must be above 0'):
                parameters['speed'] = -1.0
            with pytest.raises(InvalidParameterValueException, match='Wrong parameter type'):
                parameters['speed'] = 'fast'
            with pytest.raises(InvalidParameterValueException, match='must be above 0'):
                parameters.declare('wheels', 0, check=positive)
            assert 'wheels' not in parameters
            parameters.declare('wheels', 0)
            value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=-2.0)
            client = other.client(SetParameters, '/node/set_parameters')
            response = await client.call(parameters=[Parameter(name='speed', value=value)], timeout=PATIENCE)
            assert [(result.successful, result.reason) for result in response.results] == [
                (False, 'must be above 0')
            ]
            assert parameters['speed'] == 1.0

    play(scenario)


def test_changes_are_an_async_iterator(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            node.parameters.declare('speed', 1.0)
            with node.parameters.changes() as changes:
                waiting = asyncio.create_task(anext(changes))
                await asyncio.sleep(0)
                node.parameters['speed'] = 2.0
                assert await waiting == ('speed', 2.0)
            node.parameters['speed'] = 3.0
            assert [change async for change in changes] == []

    play(scenario)

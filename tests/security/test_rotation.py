"""Calls and goals go on while all certificates are renewed, and while one identity is revoked."""

from __future__ import annotations

from datetime import timedelta
from functools import partial
from pathlib import Path

import pytest
from helpers.isolation import isolated_env
from helpers.patience import wait_for
from helpers.processes import Program

from goalwire.security.keystore import Keystore

pytestmark = [pytest.mark.long, pytest.mark.slow]

CALLS, GOALS, RENEWALS = 10_000, 200, 3
LIFE = timedelta(seconds=20)

SERVER = """
    import rclpy
    from example_interfaces.action import Fibonacci
    from example_interfaces.srv import AddTwoInts
    from rclpy.action import ActionServer

    rclpy.init()
    node = rclpy.create_node('server')

    def add(request, response):
        response.sum = request.a + request.b
        return response

    def count(goal):
        goal.succeed()
        return Fibonacci.Result(sequence=[0, 1, goal.request.order])

    node.create_service(AddTwoInts, 'add', add)
    ActionServer(node, Fibonacci, 'count', count)
    print('ready', flush=True)
    rclpy.spin(node)
"""
CLIENT = """
    import asyncio, sys
    import goalwire
    from example_interfaces.action import Fibonacci
    from example_interfaces.srv import AddTwoInts

    calls, goals, until = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]

    async def main():
        async with goalwire.Node(sys.argv[4]) as node:
            adding = node.client(AddTwoInts, 'add')
            counting = node.action(Fibonacci, 'count')
            await adding.wait_for_server(timeout=20)
            print('ready', flush=True)
            right = wrong = reached = 0
            import os
            while right + wrong < calls or reached < goals or not os.path.exists(until):
                number = right + wrong
                answer = await adding.call(AddTwoInts.Request(a=number, b=1), timeout=10)
                right += answer.sum == number + 1
                wrong += answer.sum != number + 1
                if number % (calls // goals) == 0:
                    result = await counting.call(Fibonacci.Goal(order=reached), timeout=10)
                    reached += result.sequence[2] == reached
            print(f'{right} right, {wrong} wrong, {reached} goals', flush=True)

    asyncio.run(main())
"""


def test_nothing_is_lost_but_what_the_revoked_one_sends(tmp_path: Path) -> None:
    keystore = Keystore.create(tmp_path / 'keys')
    for name in ('robby', 'ann', 'eve'):
        keystore.add(name, 'robot', ('robot',), LIFE)
    end = tmp_path / 'end'

    def env(name: str) -> dict[str, str]:
        return {**base, 'GOALWIRE_SECURITY': f'{keystore.path}:{name}'}

    base = isolated_env('rmw_zenoh_cpp')
    honest = (str(CALLS), str(GOALS), str(end), 'ann')
    with Program(SERVER, env=env('robby')) as server:
        server.expect('ready')
        with (
            Program(CLIENT, *honest, env=env('ann')) as ann,
            Program(CLIENT, '1', '1', str(tmp_path / 'never'), 'eve', env=env('eve')) as eve,
        ):
            ann.expect('ready')
            eve.expect('ready')
            seen = {name: {keystore.identity(name).certificate.serial_number} for name in ('robby', 'ann')}

            def are_renewed(times: int) -> bool:
                for name, serials in seen.items():
                    serials.add(keystore.identity(name).certificate.serial_number)
                return all(len(serials) > times for serials in seen.values())

            wait_for(lambda: are_renewed(1))
            keystore.revoke('eve')
            assert eve.wait() != 0
            for times in range(2, RENEWALS + 1):
                wait_for(partial(are_renewed, times))
            end.touch()
            ann.expect(' goals')
            assert '0 wrong' in ann.output
            assert ann.wait() == 0

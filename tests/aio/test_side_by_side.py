"""The asyncio API on many threads at the same time, with a loop of its own on each."""

from __future__ import annotations

from itertools import count

from helpers.at_once import do_at_once
from helpers.loops import run
from helpers.patience import PATIENCE
from std_srvs.srv import SetBool

import goalwire

_NUMBERS = count()


def _switch(request: SetBool.Request) -> SetBool.Response:
    return SetBool.Response(success=request.data, message='switched')


def test_nodes_of_several_loops_serve_and_call_beside_each_other(isolated: dict[str, str]) -> None:
    async def live() -> None:
        name = f'switch_{next(_NUMBERS)}'
        async with goalwire.Node('lamp') as lamp, goalwire.Node('hand') as hand:
            lamp.service(SetBool, name, _switch)
            client = hand.client(SetBool, name)
            for turn in range(10):
                answer = await client.call(data=turn % 2 == 0, timeout=PATIENCE)
                assert answer.success is (turn % 2 == 0)

    do_at_once(4, lambda _: run(live()))

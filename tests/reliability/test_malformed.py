"""Item 13: bytes that are not a message, from a peer or changed on the way, are rejected, and that is all."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from random import Random

import pytest
from example_interfaces.action import Fibonacci
from helpers.loops import run
from helpers.outcomes import Outcomes
from helpers.patience import PATIENCE
from helpers.pending import left_pending
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import SetBool

import goalwire
from goalwire.transport.faults import Fault, FlippedBytes, Kind, Packet

from .conftest import Evidence, MakeStage

XCDR2 = bytes.fromhex('0007 0000 02000000 6100 0000')
CUT_OFF = bytes.fromhex('0001 0000 ff000000 6100 0000')
HUGE = bytes.fromhex('0001 0000 ffffffff 6100 0000')


@pytest.mark.parametrize('message', [XCDR2, CUT_OFF, HUGE], ids=['XCDR2', 'cut', 'huge'])
def test_a_message_that_is_none_reaches_no_callback_and_holds_up_nothing(
    stage: MakeStage, evidence: Evidence, capfd: pytest.CaptureFixture[str], message: bytes
) -> None:
    outcomes = Outcomes()

    async def scenario() -> None:
        async with stage() as (arm, mission, _):
            heard = mission.subscription(String, 'chatter')
            raw = Node('raw', context=arm._open_core().context)
            publisher = raw.create_publisher(String, 'chatter', 10)
            await arm.publisher(String, 'chatter').wait_for_subscribers(timeout=PATIENCE)
            publisher.publish(message)
            publisher.publish(String(data='fine'))
            assert (await anext(aiter(heard))).data == 'fine'
            outcomes.note('rejected')
            outcomes.note('done')
            raw.destroy_node()

    run(scenario())
    if message is XCDR2:
        assert 'representation 0007 is XCDR2; ROS 2 messages are plain CDR' in capfd.readouterr().err
        evidence(13, 'a message in XCDR2', outcomes)


def test_bytes_that_flip_on_the_way_end_calls_by_type_and_harm_no_other(
    stage: MakeStage, evidence: Evidence
) -> None:
    outcomes = Outcomes()

    async def scenario() -> None:
        async with stage() as (arm, mission, faults):
            arm.service(SetBool, 'set', lambda request: SetBool.Response(success=request.data, message='on'))
            client = mission.client(SetBool, 'set')
            await client.call(data=True, timeout=PATIENCE)
            flips = faults.add(FlippedBytes(number=2, name='/set'))
            for _ in range(40):
                with outcomes.counted():
                    await client.call(data=True, timeout=0.1)
            assert flips.struck >= 40
            faults.heal()
            with outcomes.counted():
                assert (await client.call(data=True, timeout=PATIENCE)).success

    run(scenario())
    assert outcomes.total == 41
    assert set(outcomes.counts) <= {
        'done',
        'DeadlineError',
        'RefusedError',
        'ServerFailedError',
        'DecodeError',
    }
    evidence(13, 'two bytes flipped in each request and reply', outcomes)


class Garbled(Fault):
    """The first byte of the content is not a bool."""

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:
        payload = bytearray(packet.payload)
        payload[4] = 7
        return (packet._replace(payload=bytes(payload)),)


@dataclass(eq=False, kw_only=True)
class Longer(Fault):
    """Bytes follow the message, as behind what rmw_serialize made."""

    extra: int = 8

    def strike(self, packet: Packet, rng: Random, now: int) -> tuple[Packet, ...]:
        return (packet._replace(payload=bytes(packet.payload) + b'\xff' * self.extra),)


@pytest.mark.parametrize('extra', [8, 16, 32])
def test_bytes_behind_messages_requests_replies_and_all_of_an_action_are_ignored(
    stage: MakeStage, evidence: Evidence, extra: int
) -> None:
    outcomes = Outcomes()

    async def count(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        goal.feedback(sequence=[0])
        return Fibonacci.Result(sequence=[goal.request.order])

    async def scenario() -> None:
        async with stage() as (arm, mission, faults):
            arm.service(SetBool, 'set', lambda request: SetBool.Response(success=request.data, message='on'))
            arm.action_server(Fibonacci, 'count', count)
            longer = faults.add(Longer(extra=extra))
            with outcomes.counted():
                assert await mission.client(SetBool, 'set').call(
                    data=True, timeout=PATIENCE
                ) == SetBool.Response(success=True, message='on')
            async with mission.action(Fibonacci, 'count').send(order=7, timeout=PATIENCE) as run_:
                with outcomes.counted():
                    assert [list(each.sequence) async for each in run_.feedback] == [[0]]
                    assert list((await run_.result).sequence) == [7]
            assert longer.struck >= 7

    run(scenario())
    assert outcomes.counts == {'done': 2}
    evidence(13, f'{extra} bytes behind each message, request and reply', outcomes)


def test_a_goal_whose_acceptance_cannot_be_read_is_called_off_and_forgotten(
    stage: MakeStage, evidence: Evidence
) -> None:
    outcomes = Outcomes()

    async def wait(_: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        try:
            await asyncio.Event().wait()
        finally:
            ended.set()
        raise AssertionError

    ended = asyncio.Event()

    async def scenario() -> None:
        async with stage() as (arm, mission, faults):
            arm.action_server(Fibonacci, 'wait', wait)
            faults.add(Garbled(kind=Kind.REPLY, name='/wait/_action/send_goal'))
            with outcomes.counted():
                await mission.action(Fibonacci, 'wait').call(timeout=PATIENCE)
            await ended.wait()
            assert left_pending(mission._open_core()) == {}

    run(scenario())
    assert outcomes.counts == {'DecodeError': 1}
    evidence(13, 'an answer to a goal that is none; the goal is called off', outcomes)

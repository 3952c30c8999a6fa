"""Exercise 2: the arm moves with feedback, refuses goals that it cannot reach, and can be stopped."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator, Sequence
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, TypeAlias

import goalwire
from goalwire.apps.course.bench import beside, wait_for_server
from goalwire.apps.course.student import Student, Wrong

if TYPE_CHECKING:
    from humanoid_interfaces.action import MoveArm

    Client: TypeAlias = 'goalwire.ActionClient[MoveArm.Goal, MoveArm.Result, MoveArm.Feedback]'

ACTION = 'move_arm'
DURATION = 1.0
LONG = 30.0
JOINTS = ['left_shoulder', 'left_elbow']
TARGET = [0.5, 1.0]
MOTIONS = (([0.2, 0.4], 0.6), (TARGET, 1.5))
"""Targets of the arm and durations of the motions, in s; several, so that a program cannot hard-code them."""
LATE = 1.0
"""Seconds by which a motion may take longer, even on a busy machine."""
ENDS_WITHIN = 10.0
LEAST_FEEDBACK = 5
ANSWERS_WITHIN = 3.0
CLOSE = 0.01
NAN = math.nan

REFUSED: tuple[tuple[str, list[str], list[float], float], ...] = (
    ('names no joint', [], [], DURATION),
    ('has two joints and one position', JOINTS, [0.5], DURATION),
    ('has a joint that the arm does not have', ['tail'], [0.5], DURATION),
    ('has a position beyond the limits of the joint', ['left_shoulder'], [9.0], DURATION),
    ('has NaN for a position', ['left_shoulder'], [NAN], DURATION),
    ('has the duration 0', JOINTS, TARGET, 0.0),
    ('has NaN for its duration', JOINTS, TARGET, NAN),
)
"""Goals that no arm can reach: what is wrong with each, its joints, positions and duration."""


async def steps(file: Path) -> AsyncIterator[str]:
    """Yield a sentence for each step that the program passes; raise Wrong at the first mistake."""
    from humanoid_interfaces.action import MoveArm

    async with beside(file) as (node, student):
        client = node.action(MoveArm, ACTION)
        await wait_for_server(node, student, client, 'action', ACTION, 'humanoid_interfaces/action/MoveArm')
        yield f'it starts, and serves {ACTION!r}'
        for target, duration in MOTIONS:
            await student.during(_move(client, student, target, duration), 'move the arm')
        yield f'{len(MOTIONS)} goals move the arm in the times that they give, with feedback on the way'
        for fault, joints, positions, duration in REFUSED:
            goal = MoveArm.Goal(joint_names=joints, positions=positions, duration=duration)
            await student.during(_insist_on_refusal(client, goal, fault), 'answer a goal')
        yield f'{len(REFUSED)} goals that no arm can reach are refused'
        stopped_at = await student.during(_cancel(client), 'cancel a goal')
        yield 'a goal is cancelled on the way, and the result says where the arm stopped'
        await student.during(_go_on(client, stopped_at), 'move the arm again')
        yield 'the next goal begins where the arm stands'


async def _move(client: Client, student: Student, target: Sequence[float], duration: float) -> None:
    began = monotonic()
    shares: list[float] = []
    times: list[float] = []
    try:
        async with client.send(
            joint_names=JOINTS, positions=target, duration=duration, timeout=ENDS_WITHIN
        ) as run:
            async for feedback in run.feedback:
                shares.append(feedback.fraction_done)
                times.append(monotonic() - began)
                if len(feedback.positions) != len(JOINTS) or list(feedback.joint_names) != JOINTS:
                    raise Wrong(
                        f'feedback has the joints {list(feedback.joint_names)} and '
                        f'{len(feedback.positions)} positions',
                        'it has the joints of the goal, in its order, and a position for each',
                    )
            result = await run.result
    except goalwire.GoalRefused:
        raise await _explain(
            student,
            f'a good goal is refused: {JOINTS} to {list(target)} within {duration:g} s',
            'look at goal_callback: it has to return GoalResponse.ACCEPT here',
        ) from None
    except goalwire.GoalAborted:
        raise await _explain(
            student,
            'a good goal ends ABORTED',
            'execute_callback did not call goal_handle.succeed(), or called abort()',
        ) from None
    except goalwire.DeadlineError:
        raise Wrong(
            f'a goal of {duration:g} s has not ended after {ENDS_WITHIN:g} s', 'look at the end of your loop'
        ) from None
    _judge_motion(duration, monotonic() - began, shares, times)
    if not result.success:
        raise await _explain(
            student, 'the goal succeeded, but its result has success=False', 'set result.success = True'
        )
    _judge_result(result, target)


async def _explain(student: Student, problem: str, advice: str) -> Wrong:
    """Return the mistake, with the exception in the program's output, or else with `advice`."""
    failure = await student.failure()
    if failure is None:
        printed = f'. What the program printed:\n{student.last_lines()}' if student.output.strip() else ''
        return Wrong(problem, advice + printed)
    return Wrong(f'{problem}: {failure.text}', failure.advice or advice)


def _judge_motion(duration: float, took: float, shares: Sequence[float], times: Sequence[float]) -> None:
    if took < 0.8 * duration or took > duration + LATE:
        raise Wrong(
            f'a goal of {duration:g} s ended after {took:.2f} s',
            'the motion has to take the duration of the goal: move a little, sleep a little, in a loop that '
            'ends when the duration is over',
        )
    if len(shares) < LEAST_FEEDBACK * min(duration, 1.0):
        raise Wrong(
            f'{len(shares)} feedback messages came during {duration:g} s',
            f'publish feedback in each turn of the loop, at least {LEAST_FEEDBACK} times a second',
        )
    if times[0] > 0.8 * took:
        raise Wrong(
            f'the first feedback came after {times[0]:.2f} s of {took:.2f} s',
            'publish it while the arm moves, not afterwards. If it is published in time, something holds up '
            'the executor: an execute callback that sleeps needs a MultiThreadedExecutor and a '
            'ReentrantCallbackGroup',
        )
    if any(not 0.0 <= share <= 1.0 for share in shares):
        raise Wrong(
            f'fraction_done goes from {min(shares):g} to {max(shares):g}',
            'it is a part of 1: 0.5 at half the way',
        )
    if list(shares) != sorted(shares) or shares[-1] - shares[0] < 0.5:
        raise Wrong(
            f'fraction_done does not rise from 0 to 1: {", ".join(f"{share:.2f}" for share in shares)}',
            'it is elapsed time / duration, 1 at most',
        )


def _judge_result(result: MoveArm.Result, target: Sequence[float]) -> None:
    reached = list(result.final_positions)
    if len(reached) != len(target) or any(abs(a - b) > CLOSE for a, b in zip(reached, target, strict=True)):
        raise Wrong(
            f'final_positions is {[round(each, 2) for each in reached]}, not {list(target)}',
            'it has the positions where the joints stand at the end, in the order of joint_names',
        )


async def _insist_on_refusal(client: Client, goal: MoveArm.Goal, fault: str) -> None:
    try:
        async with client.send(goal, timeout=ANSWERS_WITHIN, grace=0.2):
            pass
    except goalwire.GoalRefused:
        return
    except goalwire.CallError:
        pass  # The server accepted the goal, and another error followed.
    raise Wrong(
        f'a goal that {fault} is accepted',
        'every comparison with NaN is false, so ask whether a value is good, not whether it is bad'
        if 'NaN' in fault
        else 'goal_callback gets the goal before anything moves: return GoalResponse.REJECT there. Is '
        'goal_callback=… given to ActionServer?',
    )


async def _cancel(client: Client) -> float:
    """Cancel a goal during its motion; return the position at which the shoulder stopped."""
    positions: list[float] = []
    async with client.send(joint_names=['left_shoulder'], positions=[-1.0], duration=LONG, grace=0.2) as run:
        async for feedback in run.feedback:
            positions.append(feedback.positions[0])
            _judge_begin(positions[0], TARGET[0])
            if len(positions) == LEAST_FEEDBACK:
                break
        if not await _ask_to_cancel(run):
            raise Wrong(
                'the server refuses to cancel the goal',
                'without a cancel_callback every request is refused: give ActionServer one that returns '
                'CancelResponse.ACCEPT',
            )
        try:
            await _await_end(run)
        except goalwire.GoalCanceled as ended:
            result = ended.result
        except goalwire.GoalAborted:
            raise Wrong(
                'a cancelled goal ends ABORTED',
                'call goal_handle.canceled() and return a result, once goal_handle.is_cancel_requested',
            ) from None
        except TimeoutError:
            raise Wrong(
                f'a cancelled goal still runs {ANSWERS_WITHIN:g} s later',
                'look at goal_handle.is_cancel_requested in each turn of the loop',
            ) from None
        else:
            raise Wrong(
                'a cancelled goal ends SUCCEEDED', 'call goal_handle.canceled(), not succeed(), and return'
            )
    return _judge_stop(result, positions[-1])


async def _await_end(run: goalwire.Run[MoveArm.Result, MoveArm.Feedback]) -> MoveArm.Result:
    """Wait for the result of a cancelled goal, within its time limit."""
    async with asyncio.timeout(ANSWERS_WITHIN):
        return await run.result


async def _ask_to_cancel(run: goalwire.Run[MoveArm.Result, MoveArm.Feedback]) -> bool:
    try:
        return await run.cancel(timeout=ANSWERS_WITHIN)
    except goalwire.DeadlineError:
        raise Wrong(
            f'the request to cancel was not answered within {ANSWERS_WITHIN:g} s',
            'execute_callback holds up the executor: with time.sleep in it you need a MultiThreadedExecutor '
            'and a ReentrantCallbackGroup',
        ) from None


def _judge_stop(result: MoveArm.Result, last_seen: float) -> float:
    if result.success:
        raise Wrong(
            'the result of a cancelled goal has success=True', 'the arm did not arrive: set it to False'
        )
    if len(result.final_positions) != 1:
        raise Wrong(
            'the result of a cancelled goal has no final_positions',
            'whoever cancels wants to know where the arm stands now',
        )
    stopped_at = result.final_positions[0]
    if abs(stopped_at - last_seen) > 0.2:
        raise Wrong(
            f'the result says that the arm stopped at {stopped_at:.2f}, but it was last seen at '
            f'{last_seen:.2f}',
            'a cancelled goal stops on its way, and does not jump to its target',
        )
    return stopped_at


async def _go_on(client: Client, stopped_at: float) -> None:
    async with client.send(
        joint_names=['left_shoulder'], positions=[0.5], duration=DURATION, timeout=ENDS_WITHIN, grace=0.2
    ) as run:
        async for feedback in run.feedback:
            _judge_begin(feedback.positions[0], stopped_at)
            break


def _judge_begin(begins_at: float, stands_at: float) -> None:
    if abs(begins_at - stands_at) > 0.4:
        raise Wrong(
            f'the joint stands at {stands_at:.2f}, and the next goal begins at {begins_at:z.2f}',
            'begin each motion at the position that the node keeps for the joint, as in self.positions: the '
            'arm does not jump',
        )

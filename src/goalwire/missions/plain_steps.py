"""Steps that send nothing: waiting for a message, sleeping, asking a person, and code of the mission's own.

After a restart they may begin again without harm, except for the mission's own code, which runs at least
once.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from inspect import isawaitable
from typing import TYPE_CHECKING, Any

from goalwire.errors import DeadlineError, StepFailed
from goalwire.missions.journal_store import as_json
from goalwire.missions.live_step import Interrupted, LiveStep
from goalwire.missions.outcomes import Outcome
from goalwire.rules.missions.entries import Entry, MissionState

if TYPE_CHECKING:
    import goalwire


async def _begin(step: LiveStep, timeout: float | None = None) -> Entry:
    """Return the step's intent, from the journal or a new one, and set the time limit."""
    intent = step.history.intent
    if intent is None:
        return await step.begin(timeout, {})
    step.limit(intent, timeout)
    return intent


async def wait_for_message(
    step: LiveStep,
    message_type: type[Any],
    topic: str,
    condition: Callable[[Any], object] | None,
    timeout: float | None,
    qos: goalwire.QoS | int,
) -> Outcome:
    """Wait for a message that meets the condition. The timeout starts with the step, not with a restart."""
    await _begin(step, timeout)

    async def receive() -> Any:
        with step.node.subscription(message_type, topic, qos=qos) as subscription:
            async for message in subscription:
                if condition is None or condition(message):
                    return message
        raise StepFailed(f"the subscription to '{topic}' was closed")

    try:
        return Outcome(await step.until_stopped(receive()), message_type=message_type)
    except Interrupted as why:
        if why.is_stop:
            return Outcome(error=why.error)
        return Outcome(
            error=DeadlineError(f"topic '{topic}': no such message came within {timeout} s", name=topic)
        )
    except Exception as error:  # the condition itself has raised it
        return Outcome(error=_make_failure(error))


async def sleep(step: LiveStep, seconds: float) -> Outcome:
    """Sleep until `seconds` after the step began; the time without a runner counts, too."""
    await _begin(step, seconds)
    try:
        await step.until_stopped(asyncio.Event().wait())
    except Interrupted as why:
        return Outcome(error=why.error) if why.is_stop else Outcome()
    return Outcome()


async def sleep_until(step: LiveStep, when: float) -> Outcome:
    """Sleep until the system's clock shows `when`, in s since 1970."""
    await _begin(step)
    try:
        while (left := when - step.computer.wall()) > 0:
            await step.until_stopped(asyncio.sleep(left))
    except Interrupted as why:
        return Outcome(error=why.error)
    return Outcome()


async def approve(step: LiveStep, question: str, timeout: float | None) -> Outcome:
    """Ask a person. No answer within `timeout` s counts as no."""
    await _begin(step, timeout)
    try:
        return Outcome(await step.ask(MissionState.APPROVAL, question) == 'yes')
    except Interrupted as why:
        return Outcome(error=why.error) if why.is_stop else Outcome(value=False)


async def call_function(
    step: LiveStep, function: Callable[..., Any], arguments: tuple[Any, ...], timeout: float | None
) -> Outcome:
    """Call the mission's own function, plain or `async def`."""
    await _begin(step, timeout)
    try:
        value = function(*arguments)
        if isawaitable(value):
            value = await step.until_stopped(value)
        as_json(value)
    except Interrupted as why:
        return Outcome(error=why.error)
    except Exception as error:
        return Outcome(error=_make_failure(error))
    return Outcome(value)


def _make_failure(error: Exception) -> StepFailed:
    failed = StepFailed(f'{type(error).__name__}: {error}')
    failed.__cause__ = error
    return failed

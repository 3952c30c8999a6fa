"""A service call as a step. A service cannot tell if it got a request: the mission or a person decides."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from goalwire.errors import CallError, NoServerError, RefusedError, ServerFailedError, StepLost
from goalwire.missions.live_step import IfLost, Interrupted, LiveStep
from goalwire.missions.outcomes import Outcome, encode_message
from goalwire.records import record
from goalwire.rules.missions.entries import Decision

if TYPE_CHECKING:
    import goalwire

_CERTAIN = (NoServerError, RefusedError, ServerFailedError)
"""Errors after which it is certain that the call did not happen, or how it failed."""


@record
class CallRequest:
    """A mission's request to call a service once."""

    service_type: Any
    name: str
    request: Any
    timeout: float | None
    if_lost: IfLost
    idempotent: bool
    """True if making the call twice does no harm."""


class CallStep:
    """Makes one call, or goes on with it from the state in the journal."""

    def __init__(self, step: LiveStep, request: CallRequest) -> None:
        self._step = step
        self._request = request
        self._client: goalwire.Client[Any, Any] = step.clients.service(request.service_type, request.name)

    async def perform(self) -> Outcome:
        """Return the response, or the error."""
        step, request = self._step, self._request
        intent = step.history.intent
        try:
            if intent is None:
                await step.until_stopped(self._client.wait_for_server(timeout=request.timeout))
                await self._begin()
                return await self._call()
            step.limit(intent, request.timeout)
            if request.idempotent:
                return await self._call()
            return await self._decide('the call was under way when the runner ended')
        except Interrupted as why:
            return Outcome(error=why.error)
        except NoServerError as error:
            return Outcome(error=error)

    async def _begin(self) -> None:
        facts, data = encode_message(self._request.request)
        await self._step.begin(self._request.timeout, facts, data)

    async def _call(self) -> Outcome:
        self._step.boundary('before send')
        calling = await self._step.send(
            self._client.call(self._request.request, timeout=self._step.measure_left())
        )
        self._step.boundary('after send')
        try:
            response = await self._step.until_stopped(calling)
        except _CERTAIN as error:
            return Outcome(error=error)
        except CallError as error:
            if self._request.idempotent:
                return Outcome(error=error)
            return await self._decide(str(error))
        except Interrupted as why:
            if self._request.idempotent or why.is_stop:
                raise
            return await self._decide('no answer came in time')
        return Outcome(response, message_type=self._request.service_type.Response)

    async def _decide(self, why: str) -> Outcome:
        """Let the mission or a person decide, since it is unknown whether the call happened."""
        self._step.lift_limit()
        evidence = f'the call may have happened: {why}'
        decision = await self._step.decide_lost(self._request.if_lost, self._request.request, evidence)
        if decision is Decision.DONE:
            response_type = self._request.service_type.Response
            return Outcome(response_type(), message_type=response_type)
        if decision is Decision.FAIL:
            return Outcome(error=StepLost(f'{self._step.title}: {evidence}'))
        await self._begin()
        return await self._call()

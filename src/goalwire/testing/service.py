"""A scripted service: it follows the test's script, and remembers its requests."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

from goalwire.entities.service import ServiceCore
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.rules.qos import SERVICES_DEFAULT
from goalwire.testing.answers import NEVER, After, Script
from goalwire.testing.log import PATIENCE, Log, describe_differences
from goalwire.testing.spinning import host

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ServiceSupport
    from goalwire.testing.answers import Answer, Answers

RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')


class _Core(ServiceCore):
    """A server whose callback may fail because the script says so; the client gets an error."""

    def failed(self, error: Exception) -> None:
        """Report nothing: the test wanted the failure."""


class FakeService(Generic[RequestT, ResponseT]):
    """A scripted service, made by Graph.service. It has its own node and thread."""

    def __init__(
        self,
        node: NodeCore,
        support: ServiceSupport,
        name: str,
        answers: Answers[ResponseT],
        blame: Callable[[str], None],
    ) -> None:
        self._node = node
        self._blame = blame
        self._response: type = support.response
        self._script: Script[ResponseT] = Script(answers, self._response)
        self._core = _Core(node, support, name, self._answer, SERVICES_DEFAULT, ReentrantCallbackGroup())
        self.name = self._core.full_name
        self.requests: Log[RequestT] = Log(f"requests to '{self.name}'")
        """The requests that have come so far."""
        self._spinning = host(node)

    def answer_with(self, answers: Answers[ResponseT]) -> None:
        """Set the answer for later requests."""
        self._script = Script(answers, self._response)

    def _answer(self, request: RequestT, _response: object) -> object:
        self.requests.append(request)
        try:
            answer = self._script.next()
        except AssertionError as error:
            self._blame(f"service '{self.name}': {error}")
            raise
        return self._give(answer, request)

    def _give(self, answer: Answer[ResponseT], request: RequestT) -> object:
        if answer is None:
            return self._response()
        if answer is NEVER:
            return _for_ever()
        if isinstance(answer, After):
            return self._give_later(answer, request)
        if isinstance(answer, BaseException) or (
            isinstance(answer, type) and issubclass(answer, BaseException)
        ):
            raise answer
        if isinstance(answer, self._response):
            return answer
        return cast('Callable[[RequestT], object]', answer)(request)

    async def _give_later(self, later: After[ResponseT], request: RequestT) -> object:
        import asyncio

        await asyncio.sleep(later.seconds)
        answer = self._give(later.answer, request)
        return await answer if isinstance(answer, Coroutine) else answer

    # -- methods for tests -----------------------------------------------------------------------------------

    def wait_for(self, count: int = 1, *, timeout: float = PATIENCE) -> list[RequestT]:
        """Block until `count` requests have come; raises AssertionError after `timeout` s."""
        return self.requests.wait_for(count, timeout=timeout)

    def assert_called(self, count: int | None = None) -> None:
        """Raise AssertionError unless the service was called; with `count`, unless it was called exactly so
        often.
        """
        if count is None and not self.requests:
            raise AssertionError(f"service '{self.name}' was not called")
        if count is not None and len(self.requests) != count:
            raise AssertionError(f"service '{self.name}': wanted {count} calls, got {self.requests}")

    def assert_not_called(self) -> None:
        """Raise AssertionError if the service was called."""
        self.assert_called(0)

    def assert_called_with(self, **fields: object) -> None:
        """Raise AssertionError unless the fields of the last request have these values."""
        self.assert_called()
        wrong = describe_differences(self.requests[-1], fields)
        if wrong:
            raise AssertionError(f"service '{self.name}', last call: {'; '.join(wrong)}")

    def close(self) -> None:
        """Close the service, as if it died; waiting clients get an error. May be called twice."""
        self._node.destroy()
        self._spinning.close()


def _for_ever() -> Coroutine[Any, Any, None]:
    import asyncio

    async def wait() -> None:
        await asyncio.Event().wait()

    return wait()

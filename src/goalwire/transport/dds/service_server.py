"""The common part of both DDS sessions' service servers: requests that wait for their replies."""

from __future__ import annotations

from abc import abstractmethod
from typing import Generic, Protocol, TypeVar

from goalwire.transport.contract import Request, Sample
from goalwire.transport.endpoint import EndpointState, OpenPort, answered_before


class KnownClient(Protocol):
    """A client, as its request writer describes it."""

    @property
    def takes_refusals(self) -> bool:
        """True for goalwire's clients, which understand that a request will not be answered."""


ClientT = TypeVar('ClientT', bound=KnownClient)
AddressT = TypeVar('AddressT')
ReplyT = TypeVar('ReplyT')


class DdsRequest(Request, Generic[ClientT, AddressT, ReplyT]):
    """One request waiting for its reply."""

    __slots__ = ('_is_answered', '_server', 'address', 'client', 'sample')

    def __init__(
        self,
        server: DdsServer[ClientT, AddressT, ReplyT],
        client: ClientT,
        address: AddressT,
        sample: Sample,
    ) -> None:
        self.client = client
        self.address = address
        """The data by which the reply names the request."""
        self.sample = sample
        self._server = server
        self._is_answered = False

    def reply(self, payload: bytes) -> None:
        """Answer. Raises LocalError the second time, ForkedError after a fork."""
        server = self._server
        state = server.state
        if state.guard.is_forked:
            state.check()
        if self._is_answered:
            raise answered_before(state)
        self._is_answered = True
        if server.waiting.pop(self, False):
            server.send(self, server.write_reply(self.address, payload))

    def cancel(self, reason: str = '') -> None:
        """End the request. Only goalwire's clients learn that; another client's call ends with the server."""
        server = self._server
        if server.state.is_forked:
            server.state.check()
        if server.waiting.pop(self, False) and self.client.takes_refusals:
            server.send(self, server.write_refusal(self.address, reason))


class DdsServer(OpenPort, Generic[ClientT, AddressT, ReplyT]):
    """A service server that is open until its state is closed."""

    def __init__(self, state: EndpointState, gid: bytes) -> None:
        super().__init__(state, gid)
        self.waiting: dict[DdsRequest[ClientT, AddressT, ReplyT], bool] = {}
        """The requests that are neither answered nor cancelled. Each value is True, so that `pop(…, False)`
        says whether the request was still there.

        Closing clears the dict: the clients learn of the server's end from the graph.
        """
        state.undo.append(self.waiting.clear)

    @staticmethod
    @abstractmethod
    def write_reply(address: AddressT, payload: bytes, /) -> ReplyT:
        """Return a reply as the client expects it."""

    @staticmethod
    @abstractmethod
    def write_refusal(address: AddressT, reason: str, /) -> ReplyT:
        """Return a reply that tells one of goalwire's clients that its request will not be answered."""

    @abstractmethod
    def send(self, request: DdsRequest[ClientT, AddressT, ReplyT], reply: ReplyT) -> None:
        """Send one reply once its client can receive it."""

"""The clients that a runner's missions share, one for each action and each service."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import goalwire
    from goalwire.missions.this_computer import ThisComputer


class Clients:
    """Makes clients when they are first needed. They end with the runner: a node may have many runners."""

    def __init__(self, node: goalwire.Node, computer: ThisComputer) -> None:
        self._node = node
        self._computer = computer
        self._actions: dict[tuple[Any, str], goalwire.ActionClient[Any, Any, Any]] = {}
        self._services: dict[tuple[Any, str], goalwire.Client[Any, Any]] = {}
        self._replaced: list[goalwire.ActionClient[Any, Any, Any]] = []
        self._since: dict[str, float] = {}
        self._journals: dict[tuple[str, frozenset[str]], str] = {}
        self.sent: dict[bytes, goalwire.Run[Any, Any]] = {}
        """The goals, by their ids, that go on while their missions do other steps. Their results are awaited
        from the beginning, so they do not expire at the server."""

    def action(self, action_type: Any, name: str) -> goalwire.ActionClient[Any, Any, Any]:
        """Return the client of an action."""
        known = self._actions.get((action_type, name))
        return known or self.renew_action(action_type, name)

    def renew_action(self, action_type: Any, name: str) -> goalwire.ActionClient[Any, Any, Any]:
        """Replace the client of an action. Goals under way go on with the old one."""
        client = self._node.action(action_type, name)
        if replaced := self._actions.get((action_type, name)):
            self._replaced.append(replaced)
        self._actions[action_type, name] = client
        self._since[client.name] = self._computer.steady()
        return client

    def measure_listening(self, client: goalwire.ActionClient[Any, Any, Any]) -> float:
        """Return for how many s this client has received the server's topics."""
        return self._computer.steady() - self._since[client.name]

    async def journal(self, client: goalwire.ActionClient[Any, Any, Any]) -> str:
        """Return the id of the journal of an action's server; '' if it has none, or does not answer.

        Each incarnation of a server is asked until it has answered.
        """
        asked = client.name, client.server_snapshot().servers
        if asked not in self._journals:
            found = await client.find_journal()
            if found is None:
                return ''
            self._journals[asked] = found
        return self._journals[asked]

    def service(self, service_type: Any, name: str) -> goalwire.Client[Any, Any]:
        """Return the client of a service."""
        client = self._services.get((service_type, name))
        if client is None:
            client = self._services[service_type, name] = self._node.client(service_type, name)
        return client

    async def close(self) -> None:
        """Await no result any more, and close the clients. The goals go on."""
        while self.sent:
            _, run = self.sent.popitem()
            await run.__aexit__(None, None, None)
        for client in (*self._replaced, *self._actions.values(), *self._services.values()):
            client.close()

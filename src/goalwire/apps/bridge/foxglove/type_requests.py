"""Requests definitions of unknown types from nodes, each type once for each list that a client is shown."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.apps.bridge.foxglove import frames
from goalwire.apps.bridge.foxglove.client import Client
from goalwire.errors import UnknownInterfaceError


class TypeRequests:
    """The requests of one of a client's lists: its topics or its services."""

    def __init__(self, client: Client, update: Callable[[], object]) -> None:
        """`update` is called once a definition has come, so that the list shows what has this type."""
        self._client = client
        self._update = update
        self._asked: set[str] = set()

    def ask_for(self, type_name: str) -> None:
        """Request the definition of a type. The client gets a warning if no node has it."""
        if type_name not in self._asked:
            self._asked.add(type_name)
            self._client.start(self._fetch(type_name))

    async def _fetch(self, type_name: str) -> None:
        try:
            await self._client.hub.interfaces.find(type_name, type_name.split('/')[1])
        except UnknownInterfaceError as error:
            self._client.tell(str(error), frames.WARNING)
        else:
            self._update()

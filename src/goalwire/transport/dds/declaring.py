"""One endpoint on its way onto the wire, and `undo`, which takes it off again."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack

from goalwire.transport.dds.core import Core
from goalwire.transport.dds.intake import Intake
from goalwire.transport.place import Place


class Declaration:
    """What is declared so far of one endpoint; what `undo` holds is undone last first."""

    __slots__ = ('_core', '_intakes', 'place', 'undo')

    def __init__(self, core: Core) -> None:
        self._core = core
        self._intakes: list[tuple[str, Intake]] = []
        self.undo = ExitStack()
        self.place: Place

    def take_in(self, topic: str, intake: Intake) -> None:
        """Let a reader's messages in once the endpoint is shown."""
        self._intakes.append((topic, intake))

    def show(self, node_id: int, readers: Iterable[bytes], writers: Iterable[bytes]) -> None:
        """Tell the others whose this endpoint is, then let messages in."""
        core, gids = self._core, (*readers, *writers)
        core.announcement.add(node_id, readers, writers)
        self.undo.callback(core.announce)
        self.undo.callback(core.announcement.remove, node_id, gids)
        core.announce()
        for topic, intake in self._intakes:
            core.intakes.add(topic, intake)
            self.undo.callback(self._shut, topic, intake)
            core.vigil.watch(intake.reader.condition, intake.drain)

    def _shut(self, topic: str, intake: Intake) -> None:
        intake.closed = True
        self._core.intakes.remove(topic, intake)
        self._core.vigil.unwatch(intake.reader.condition)

"""Records a bag, only one at a time for all browsers, until a user ends it."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from datetime import datetime
from fnmatch import translate
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

import goalwire
from goalwire.apps.bag.recorder import Recorder
from goalwire.apps.bag.selection import Names, Selection
from goalwire.errors import BagError, GoalwireError
from goalwire.execution.asyncio.waiting import in_thread
from goalwire.records import record
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.writer import Writer

if TYPE_CHECKING:
    from goalwire.apps.bag.options import RecordOptions
    from goalwire.apps.console.settings import Settings

_EVERYTHING = Names(all=True)


@record
class Wanted:
    """The topics, services and actions that are recorded, by globs such as /arm/*; without any, all."""

    names: tuple[str, ...] = ()
    out: tuple[str, ...] = ()
    """Names to leave out, even if `names` has them."""
    preset: str = 'none'
    """How the file is compressed: a name of rosbag2.writer.PRESETS."""

    @property
    def selection(self) -> Selection:
        """The choice in the recorder's own format."""
        kinds = Names() if self.names else _EVERYTHING
        return Selection(kinds, kinds, kinds, regex=_any_of(self.names), regex_out=_any_of(self.out))


def _any_of(globs: Sequence[str]) -> str:
    return '|'.join(rf'\A{translate(glob)}' for glob in globs)


class LiveRecording:
    """Starts and ends recordings, and holds the state of the latest one. Only for the loop's thread.

    A recording has a node of its own, so that it also records messages of the console itself.
    """

    def __init__(self, node: goalwire.Node, settings: Settings, options: RecordOptions | None = None) -> None:
        """Nothing is recorded yet; bags are made in the folder `settings.record_to`."""
        self._node = node
        self._settings = settings
        self._options = options
        self._recorder: Recorder | None = None
        self._task: asyncio.Task[None] | None = None
        self._began = self._ended = 0.0
        self.path = ''
        """The absolute path of the latest bag; '' if there was none."""
        self.problem = ''
        """The error that has ended the latest recording, such as a full disk; else ''."""
        self._kept: Counter[str] | None = None
        """After a failure: the numbers of messages in the file, by topic."""

    # -- starting and ending ---------------------------------------------------------------------------------

    async def start(self, wanted: Wanted) -> None:
        """Begin a new bag. Raises NotAllowedError, BagError if a bag is being recorded or cannot be made."""
        self._settings.check_may_record()
        if self.is_running:
            raise BagError(f"'{self.path}' is being recorded: end that before the next")
        name = f'rosbag2_{datetime.now().astimezone():%Y_%m_%d-%H_%M_%S}'
        self.path, self.problem = str(Path(self.folder) / name), ''
        self._recorder = self._kept = None
        self._task = asyncio.create_task(self._record(wanted, made := asyncio.Event()))
        opening = asyncio.create_task(made.wait())
        await asyncio.wait({self._task, opening}, return_when=asyncio.FIRST_COMPLETED)
        opening.cancel()
        if self.problem:
            raise BagError(self.problem)

    async def stop(self) -> None:
        """End the recording, if there is one, and wait until its bag is closed."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.wait({self._task})

    # -- state of the latest recording -----------------------------------------------------------------------

    @property
    def folder(self) -> str:
        """The absolute path of the folder in which bags are made."""
        return str(Path(self._settings.record_to).resolve())

    @property
    def is_running(self) -> bool:
        """True while a bag is being recorded or closed."""
        return self._task is not None and not self._task.done()

    @property
    def seconds(self) -> float:
        """The duration of the latest recording, in s."""
        return (monotonic() if self.is_running else self._ended) - self._began

    @property
    def byte_count(self) -> int:
        """The size of the latest bag's messages, in bytes."""
        return 0 if self._recorder is None else self._recorder.byte_count

    def types(self) -> dict[str, str]:
        """Return the type of each topic of the latest bag."""
        return {} if self._recorder is None else self._recorder.types()

    def counts(self) -> Counter[str]:
        """Return how many messages of each topic the latest bag has."""
        if self._kept is not None:
            return self._kept
        return Counter() if self._recorder is None else self._recorder.counts()

    def count_lost(self) -> Counter[str]:
        """Return how many messages of each topic are not in the bag: dropped here, or lost on their way."""
        if self._recorder is None:
            return Counter()
        dropped, missed = self._recorder.losses
        failed = Counter[str]() if self._kept is None else self._recorder.counts() - self._kept
        return dropped.copy() + missed.copy() + failed

    # -- the recording's task --------------------------------------------------------------------------------

    async def _record(self, wanted: Wanted, made: asyncio.Event) -> None:
        self._began = monotonic()
        try:
            bag = await in_thread(lambda: Writer(self.path, preset=wanted.preset))
        except (BagError, OSError) as error:
            self._fail(f'it cannot be made: {error}')
            return
        name = f'{self._node.name.rpartition("/")[2]}_recorder'
        try:
            node = goalwire.Node(name, context=self._node.context)
            recorder = Recorder(node, bag, wanted.selection, self._options)
            async with node, recorder:
                self._recorder = recorder
                made.set()
                with suppress(asyncio.CancelledError):  # the normal end of a recording
                    await recorder.wait()
        except GoalwireError as error:
            self._fail(str(error))
        finally:
            self._ended = monotonic()
            with suppress(BagError):  # logged above
                bag.close()
            if self.problem:
                self._kept = await in_thread(lambda: _counts_in(self.path))

    def _fail(self, reason: str) -> None:
        self.problem = reason
        self._ended = monotonic()
        self._node.logger.error(f"recording '{self.path}' has ended: {reason}")


def _counts_in(path: str) -> Counter[str]:
    """Return how many messages of each topic a bag has."""
    try:
        with Reader(path) as bag:
            return Counter(bag.counts)
    except (BagError, OSError):
        return Counter()

"""Regression tests from a bag: the bag's requests and goals are sent to the tested program."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING

from goalwire.apps.bag.live_comparison import Replay, ReplayOptions
from goalwire.apps.bag.message_comparison import Difference, Tolerance
from goalwire.rosbag2.reader import Reader
from goalwire.testing.calls import run_here

if TYPE_CHECKING:
    from goalwire.apps.bag.selection import Selection
    from goalwire.testing.graph import Graph


class Expect:
    """`gw_expect('bag')` fails the test if the servers in the graph answer differently from the bag."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def __call__(
        self,
        bag: str | PathLike[str],
        *,
        tolerance: float = 0.0,
        feedback_tolerance: int = 0,
        ignore_stamps: bool = False,
        ignore_fields: tuple[str, ...] = (),
        selection: Selection | None = None,
        rate: float = 1.0,
        timeout: float = 10.0,
    ) -> None:
        """Send the calls and goals of a bag, and block until all answers have come.

        Raises AssertionError with a line for each field that differs. `tolerance` is for floating-point
        fields, `timeout` is the time in s for each answer; a goal gets this time in addition to its recorded
        duration. Raises BagError for a bag without calls, InterfaceError for types that are unknown here.
        """
        allowed = Tolerance(tolerance, feedback_tolerance, ignore_stamps, tuple(ignore_fields))
        options = ReplayOptions(selection, allowed, rate, timeout)
        differences = self.differences(bag, options)
        if differences:
            raise AssertionError('\n'.join(map(str, differences)))

    def differences(self, bag: str | PathLike[str], options: ReplayOptions | None = None) -> list[Difference]:
        """Send the calls and goals as `__call__` does, and return the differences."""

        async def replay() -> list[Difference]:
            with Reader(bag) as reader:
                async with self._graph.node('bag_player') as node:
                    return await Replay(node, reader, options).run()

        return run_here(replay())

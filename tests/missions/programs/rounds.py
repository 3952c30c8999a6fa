"""A mission that drives to places, one after the other."""

from __future__ import annotations

from example_interfaces.action import Fibonacci

from goalwire.missions import Steps, mission


@mission(resume='auto')
async def rounds(m: Steps, places: int) -> int:
    drive = m.action(Fibonacci, 'drive')
    for place in range(places):
        await drive.call(order=place)
    return places

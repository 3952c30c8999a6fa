"""A mission that drives to places one after the other, with the real rclpy's interfaces."""

from __future__ import annotations

from test_msgs.action import Fibonacci  # type: ignore[import-not-found]  # of the real rclpy

from goalwire.missions import Steps, mission


@mission(resume='auto')
async def rounds(m: Steps, places: int) -> int:
    drive = m.action(Fibonacci, 'drive')
    for place in range(places):
        await drive.call(order=place)
    return places

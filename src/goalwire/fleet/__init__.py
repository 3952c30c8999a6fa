"""Fleets: many robots, each in a namespace of its own, seen and commanded together.

`from goalwire.fleet import Fleet`. See docs/how-to/fleets.md.
"""

from goalwire.fleet.fleet import Fleet
from goalwire.fleet.job import GoalReport
from goalwire.fleet.state import RobotState

__all__ = ['Fleet', 'GoalReport', 'RobotState']

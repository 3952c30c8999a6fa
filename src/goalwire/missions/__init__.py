"""Durable missions: async functions whose steps are kept in a journal, so that they go on after a crash.

`from goalwire.missions import Runner, mission`. See docs/how-to/missions.md.
"""

from goalwire.missions.definition import Definition, mission
from goalwire.missions.mission_run import MissionRun
from goalwire.missions.offers import offer
from goalwire.missions.parallel_goal_steps import SentGoal
from goalwire.missions.runner import Runner
from goalwire.missions.steps import ActionSteps, CallSteps, Steps
from goalwire.missions.undo import Undo
from goalwire.rules.missions.entries import MissionState

__all__ = [
    'ActionSteps',
    'CallSteps',
    'Definition',
    'MissionRun',
    'MissionState',
    'Runner',
    'SentGoal',
    'Steps',
    'Undo',
    'mission',
    'offer',
]

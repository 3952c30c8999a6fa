"""The asyncio API: nodes for programs of `async def` functions. See docs/how-to/asyncio-api.md."""

from goalwire.aio.action.client import ActionClient, CancelAnswer, GoalProbe, GoalState, Run
from goalwire.aio.action.server import ActionServer, Goal
from goalwire.aio.node import Node
from goalwire.aio.parameters import Parameters
from goalwire.aio.services import Client, Service
from goalwire.aio.timer import Timer
from goalwire.aio.topics import Publisher, Subscription

__all__ = [
    'ActionClient',
    'ActionServer',
    'CancelAnswer',
    'Client',
    'Goal',
    'GoalProbe',
    'GoalState',
    'Node',
    'Parameters',
    'Publisher',
    'Run',
    'Service',
    'Subscription',
    'Timer',
]

"""The asyncio API: nodes for programs that are made of `async def`. See docs/asyncio-api.md."""

from goalwire.aio.action.client import ActionClient, CancelAnswer, Run
from goalwire.aio.action.server import ActionServer, Goal
from goalwire.aio.client import Client
from goalwire.aio.node import Node
from goalwire.aio.parameters import Parameters
from goalwire.aio.publisher import Publisher
from goalwire.aio.service import Service
from goalwire.aio.subscription import Subscription
from goalwire.aio.timer import Timer

__all__ = [
    'ActionClient',
    'ActionServer',
    'CancelAnswer',
    'Client',
    'Goal',
    'Node',
    'Parameters',
    'Publisher',
    'Run',
    'Service',
    'Subscription',
    'Timer',
]

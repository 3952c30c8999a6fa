"""The rules of actions: the table of a goal's states; action server and client as reactors without I/O."""

from goalwire.rules.goals.cancel_requests import CancelCode
from goalwire.rules.goals.client import GoalClient, SentGoals
from goalwire.rules.goals.goal_book import RESULT_TIMEOUT_NS, ServedGoals
from goalwire.rules.goals.ids import NO_ID, GoalId, new_goal_id
from goalwire.rules.goals.policy import GoalPolicy, OnClientLost, parallel, preempt, queue, single
from goalwire.rules.goals.server import GoalServer
from goalwire.rules.goals.states import TABLE, GoalEvent, GoalStatus
from goalwire.rules.goals.status_array import decode_status_array

__all__ = [
    'NO_ID',
    'RESULT_TIMEOUT_NS',
    'TABLE',
    'CancelCode',
    'GoalClient',
    'GoalEvent',
    'GoalId',
    'GoalPolicy',
    'GoalServer',
    'GoalStatus',
    'OnClientLost',
    'SentGoals',
    'ServedGoals',
    'decode_status_array',
    'new_goal_id',
    'parallel',
    'preempt',
    'queue',
    'single',
]

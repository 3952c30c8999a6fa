"""rclpy.callback_groups: groups that set which callbacks may run at the same time."""

from goalwire.execution.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from rclpy._reexports import reexport

__all__ = ['CallbackGroup', 'MutuallyExclusiveCallbackGroup', 'ReentrantCallbackGroup']

reexport(__name__)

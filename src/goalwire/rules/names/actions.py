"""The five names of an action on the wire: three services and two topics below `<name>/_action/`."""

from __future__ import annotations

from goalwire.records import record


@record
class ActionNames:
    """The names of the action `name` on the wire. Each name is remapped separately, as in ROS 2."""

    name: str

    @property
    def send_goal(self) -> str:
        """The service that takes goals."""
        return f'{self.name}/_action/send_goal'

    @property
    def cancel_goal(self) -> str:
        """The service that cancels goals."""
        return f'{self.name}/_action/cancel_goal'

    @property
    def get_result(self) -> str:
        """The service that answers when a goal has ended."""
        return f'{self.name}/_action/get_result'

    @property
    def feedback(self) -> str:
        """The topic with the feedback of all goals."""
        return f'{self.name}/_action/feedback'

    @property
    def status(self) -> str:
        """The topic with the status array, which is transient local."""
        return f'{self.name}/_action/status'

"""rclpy.lifecycle.managed_entity: what goes through a node's transitions with it."""

from goalwire.entities.managed_entity import ManagedEntity, SimpleManagedEntity
from goalwire.protocol.lifecycle import TransitionCallbackReturnType

TransitionCallbackReturn = TransitionCallbackReturnType

__all__ = ['ManagedEntity', 'SimpleManagedEntity', 'TransitionCallbackReturn']

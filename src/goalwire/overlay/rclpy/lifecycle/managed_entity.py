"""rclpy.lifecycle.managed_entity: what goes through a node's transitions with it."""

from goalwire.entities.lifecycle.managed_entity import ManagedEntity, SimpleManagedEntity
from goalwire.rules.lifecycle import TransitionCallbackReturnType
from rclpy._reexports import reexport

TransitionCallbackReturn = TransitionCallbackReturnType

__all__ = ['ManagedEntity', 'SimpleManagedEntity', 'TransitionCallbackReturn']

reexport(__name__)

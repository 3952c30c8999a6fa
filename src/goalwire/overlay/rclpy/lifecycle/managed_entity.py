"""rclpy.lifecycle.managed_entity: entities that follow their node's transitions."""

from goalwire.entities.lifecycle.managed_entity import ManagedEntity, SimpleManagedEntity
from goalwire.rules.lifecycle import TransitionCallbackReturnType
from rclpy._reexports import reexport

TransitionCallbackReturn = TransitionCallbackReturnType

__all__ = ['ManagedEntity', 'SimpleManagedEntity', 'TransitionCallbackReturn']

reexport(__name__)

"""The callbacks of a node that run before, while and after its parameters are set, under rclpy's names."""

from __future__ import annotations

from typing import TypeVar

from goalwire.rules.parameters import SetCallbacks
from goalwire.rules.parameters.callbacks import After, Before, On

_Callback = TypeVar('_Callback', Before, On, After)


class SetParametersCallbacks:
    """Mixed into Node. SetCallbacks holds the lists and calls what is in them."""

    def _ros_init_set_callbacks(self) -> None:
        self._ros_set_callbacks = SetCallbacks()

    def add_pre_set_parameters_callback(self, callback: Before) -> None:
        """Call `callback(parameters)` before a set; the list it returns is set instead. Raises TypeError."""
        _add(callback, self._ros_set_callbacks.before)

    def add_on_set_parameters_callback(self, callback: On) -> None:
        """Ask `callback(parameters)` for a SetParametersResult before parameters change. Raises TypeError."""
        _add(callback, self._ros_set_callbacks.on)

    def add_post_set_parameters_callback(self, callback: After) -> None:
        """Call `callback(parameters)` after a set that changed them. Raises TypeError."""
        _add(callback, self._ros_set_callbacks.after)

    def remove_pre_set_parameters_callback(self, callback: Before) -> None:
        """Forget a callback; raises ValueError if it was not added."""
        self._ros_set_callbacks.before.remove(callback)

    def remove_on_set_parameters_callback(self, callback: On) -> None:
        """Forget a callback; raises ValueError if it was not added."""
        self._ros_set_callbacks.on.remove(callback)

    def remove_post_set_parameters_callback(self, callback: After) -> None:
        """Forget a callback; raises ValueError if it was not added."""
        self._ros_set_callbacks.after.remove(callback)

    # rclpy's names for the lists, which programs and tests read

    @property
    def _pre_set_parameters_callbacks(self) -> list[Before]:
        return self._ros_set_callbacks.before

    @property
    def _on_set_parameters_callbacks(self) -> list[On]:
        return self._ros_set_callbacks.on

    @property
    def _post_set_parameters_callbacks(self) -> list[After]:
        return self._ros_set_callbacks.after


def _add(callback: _Callback, callbacks: list[_Callback]) -> None:
    if not callable(callback):
        raise TypeError(f'Callback must be callable, got {type(callback)}')
    callbacks.insert(0, callback)

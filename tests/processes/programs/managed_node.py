"""A managed node of the given name; a second argument names a callback that fails the first time."""

from __future__ import annotations

import sys

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn


class Managed(LifecycleNode):
    def __init__(self, name: str, failing: str) -> None:
        super().__init__(name)
        self.failing = failing

    def answer(self, callback: str, state: LifecycleState) -> TransitionCallbackReturn:
        print(f'{callback} from {state.label}')
        if callback != self.failing:
            return TransitionCallbackReturn.SUCCESS
        self.failing = ''
        raise OSError('the laser is not plugged in')

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self.answer('on_configure', state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self.answer('on_activate', state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self.answer('on_deactivate', state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self.answer('on_cleanup', state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self.answer('on_shutdown', state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self.answer('on_error', state)


def main() -> None:
    name, failing = [*sys.argv[1:], ''][:2]
    rclpy.init(args=[])
    node = Managed(name, failing)
    try:
        print('ready')
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        node.destroy_node()
        print('left')


if __name__ == '__main__':
    main()

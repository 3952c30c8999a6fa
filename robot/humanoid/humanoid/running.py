"""Run nodes as one program: until Ctrl-C, SIGTERM or the end of the process that started it."""

from __future__ import annotations

import signal
import threading
import traceback
from collections.abc import Callable, Iterable, Sequence
from types import FrameType

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from humanoid.domain import taking_part
from humanoid.text import brief

LONGEST_TRACEBACK = 4000  # characters: an exception's text may quote a long message of a peer


class BadParameter(ValueError):
    """A program cannot run with a parameter's value; the text names it and the values that are allowed."""


def check_range(name: str, value: float, lowest: float, greatest: float) -> None:
    """Raise BadParameter if a parameter is outside its bounds, or NaN."""
    if not lowest <= value <= greatest:  # NaN included
        raise BadParameter(f'the parameter {name} is {value}, not a number from {lowest:g} to {greatest:g}')


def run(make: Callable[[], Node | Iterable[Node]], args: Sequence[str] | None = None) -> int:
    """Spin the nodes on one thread until the program is told to stop; then return exit code 0.

    In rclpy an exception of a callback leaves spin, which ends a program. A robot's server must survive
    a request that it cannot handle: it logs the traceback and continues to spin.
    """
    _obey_first_interrupt()
    with taking_part():
        nodes: list[Node] = []
        try:
            join(args)
            made = make()
            executor = SingleThreadedExecutor()
            for node in [made] if isinstance(made, Node) else made:
                nodes.append(node)
                executor.add_node(node)
            while rclpy.ok():
                _spin(executor, nodes[0])
        except (KeyboardInterrupt, ExternalShutdownException):
            pass
        except (BadParameter, ParameterException) as error:
            raise SystemExit(f'humanoid: {brief(str(error))}') from None
        except Exception:
            if rclpy.ok():  # else the program was told to stop while its nodes were made
                raise
        finally:
            for node in nodes:
                node.destroy_node()
            rclpy.try_shutdown()
    return 0


def _obey_first_interrupt() -> None:
    """Let the first Ctrl-C end the program, and ignore later ones: they would disturb its end.

    Does nothing if Ctrl-C is ignored, or handled in another way.
    """
    if (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    ):
        signal.signal(signal.SIGINT, _interrupt)


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    raise KeyboardInterrupt


def join(args: Sequence[str] | None, handlers: SignalHandlerOptions | None = None) -> None:
    """Initialise ROS 2. Arguments that it cannot read end the program with one line and exit code 1."""
    try:
        rclpy.init(args=args, signal_handler_options=handlers)
    except RuntimeError as error:  # its text names the argument and the error
        raise SystemExit(f'humanoid: {brief(str(error))}') from None


def _spin(executor: SingleThreadedExecutor, node: Node) -> None:
    """Spin until a callback raises, and log that; or until the program is told to stop."""
    try:
        executor.spin()
    except ExternalShutdownException:
        raise
    except Exception as error:
        if rclpy.ok():  # failures during the shutdown are caused by the shutdown
            log_failure(node, error)


def log_failure(node: Node, error: Exception) -> None:
    """Log a callback's exception at most once a second: a timer may fail at each tick."""
    text = brief(''.join(traceback.format_exception(error)).rstrip(), LONGEST_TRACEBACK)
    node.get_logger().error(f'a callback failed, the server goes on:\n{text}', throttle_duration_sec=1.0)

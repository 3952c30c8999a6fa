"""Runs nodes as one program: until Ctrl-C, SIGTERM, or the end of the process that started the program."""

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

LONGEST_TRACEBACK = 4000  # characters, without the exception's own text, which may quote a received message


class BadParameter(ValueError):
    """A program cannot run with a parameter's value; the text names it and the values that are allowed."""


def check_range(name: str, value: float, lowest: float, greatest: float) -> None:
    """Raise BadParameter if a parameter is outside its bounds, or NaN."""
    if not lowest <= value <= greatest:  # NaN included
        raise BadParameter(f'the parameter {name} is {value}, not a number from {lowest:g} to {greatest:g}')


def run(make: Callable[[], Node | Iterable[Node]], args: Sequence[str] | None = None) -> int:
    """Spin the nodes on one thread until the program is told to stop; then return exit code 0.

    In rclpy a callback's exception leaves spin, and so ends the program. A robot's server must survive a
    request that it cannot handle: here the traceback is logged, and the nodes spin on.
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
            if rclpy.ok():  # not ok: a signal came while the nodes were made
                raise
        finally:
            for node in nodes:
                node.destroy_node()
            rclpy.try_shutdown()
    return 0


def _obey_first_interrupt() -> None:
    """Let the first Ctrl-C end the program, and ignore later ones, which would interrupt its cleanup.

    Does nothing if Ctrl-C is ignored already, or has a handler of its own.
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
    """Initialise ROS 2. Arguments that ROS 2 cannot read end the program with one line and exit code 1."""
    try:
        rclpy.init(args=args, signal_handler_options=handlers)
    except RuntimeError as error:  # for bad arguments, which the error's text names
        raise SystemExit(f'humanoid: {brief(str(error))}') from None


def _spin(executor: SingleThreadedExecutor, node: Node) -> None:
    """Spin until the program is told to stop, or a callback raises an exception, which is logged."""
    try:
        executor.spin()
    except ExternalShutdownException:
        raise
    except Exception as error:
        if rclpy.ok():  # after a shutdown, failures are only its consequence
            log_failure(node, error)


def log_failure(node: Node, error: Exception) -> None:
    """Log a callback's exception at most once a second: a timer may fail at each tick."""
    words = ''.join(traceback.format_exception_only(error)).rstrip()
    frames = ''.join(traceback.format_exception(error)).rstrip().removesuffix(words)
    text = f'{brief(frames.rstrip(), LONGEST_TRACEBACK)}\n{brief(words)}'
    node.get_logger().error(f'a callback failed, the server goes on:\n{text}', throttle_duration_sec=1.0)

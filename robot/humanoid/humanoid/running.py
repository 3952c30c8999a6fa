"""Run nodes as one program: until Ctrl-C, SIGTERM or the end of whoever started it."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable, Sequence

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from humanoid.domain import taking_part
from humanoid.text import brief

LONGEST_TRACEBACK = 4000  # characters: an exception's text may quote all that a peer has sent


class BadParameter(ValueError):
    """A program cannot run with the value of a parameter; the text names it, and says which values can be."""


def check_range(name: str, value: float, lowest: float, greatest: float) -> None:
    """Raise BadParameter if a parameter is beyond its bounds, or not a number."""
    if not lowest <= value <= greatest:  # NaN included
        raise BadParameter(f'the parameter {name} is {value}, not a number from {lowest:g} to {greatest:g}')


def run(make: Callable[[], Node | Iterable[Node]], args: Sequence[str] | None = None) -> int:
    """Spin the node, or nodes, on one thread until it is told to stop, which is a success: exit code 0.

    rclpy lets an exception of a callback out of spin, which ends the program. A robot's server outlives
    a request that it cannot handle: it logs the traceback and spins on.
    """
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
            if rclpy.ok():  # else it was told to stop while its nodes were made
                raise
        finally:
            for node in nodes:
                node.destroy_node()
            rclpy.try_shutdown()
    return 0


def join(args: Sequence[str] | None, handlers: SignalHandlerOptions | None = None) -> None:
    """Initialise ROS 2. Arguments that it cannot read end the program with one line and exit code 1."""
    try:
        rclpy.init(args=args, signal_handler_options=handlers)
    except RuntimeError as error:  # it says which argument, and what is wrong with it
        raise SystemExit(f'humanoid: {brief(str(error))}') from None


def _spin(executor: SingleThreadedExecutor, node: Node) -> None:
    """Until a callback raises, which is logged as the node's failure, or the program is told to stop."""
    try:
        executor.spin()
    except ExternalShutdownException:
        raise
    except Exception as error:
        if rclpy.ok():  # what fails during the shutdown fails because of it
            log_failure(node, error)


def log_failure(node: Node, error: Exception) -> None:
    """Log what a callback raised: at most once a second, for a timer may fail at each tick."""
    text = brief(''.join(traceback.format_exception(error)).rstrip(), LONGEST_TRACEBACK)
    node.get_logger().error(f'a callback failed, the server goes on:\n{text}', throttle_duration_sec=1.0)

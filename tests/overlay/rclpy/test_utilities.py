"""rclpy.utilities."""

from __future__ import annotations

import sys

import pytest
import rclpy.utilities as tested

from goalwire.errors import RCLInvalidROSArgsError, UnknownROSArgsError


@pytest.mark.parametrize(
    ('given', 'left'),
    [
        (['p', 'a', '--ros-args', '-r', 'x:=y', '--', 'b'], ['p', 'a', 'b']),
        (['p', '--ros-args', '-p', 'a:=1', '--log-level', 'info'], ['p']),
        ([], []),
        (['p', 'a'], ['p', 'a']),
    ],
)
def test_ros_arguments_are_removed(given: list[str], left: list[str]) -> None:
    assert tested.remove_ros_args(given) == left


def test_arguments_that_cannot_be_read_are_not_removed() -> None:
    with pytest.raises(RCLInvalidROSArgsError, match=r'^Failed to parse ROS arguments: '):
        tested.remove_ros_args(['p', '--ros-args', '-r', 'bad'])
    with pytest.raises(UnknownROSArgsError, match='--bad'):
        tested.remove_ros_args(['p', '--ros-args', '--bad'])


def test_a_remap_rule_outside_of_ros_args_counts_with_a_warning(capfd: pytest.CaptureFixture[str]) -> None:
    assert tested.remove_ros_args(['a', '-r', 'x:=y']) == ['a', '-r']
    text = "[rcl]: Found remap rule 'x:=y'. This syntax is deprecated. Use '--ros-args --remap x:=y' instead."
    assert text in capfd.readouterr().err


def test_the_program_s_own_arguments_are_the_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, 'argv', ['prog', 'x', '--ros-args', '-r', 'a:=b'])
    assert tested.remove_ros_args() == ['prog', 'x']


@pytest.mark.parametrize(('seconds', 'nanoseconds'), [(None, -1), (-0.5, -1), (0, 0), (1.5, 1_500_000_000)])
def test_timeouts_become_nanoseconds(seconds: float | None, nanoseconds: int) -> None:
    assert tested.timeout_sec_to_nsec(seconds) == nanoseconds


def test_a_timeout_is_a_number() -> None:
    with pytest.raises(TypeError):
        tested.timeout_sec_to_nsec('x')  # type: ignore[arg-type]


def test_the_wire_in_use_is_named(isolated: dict[str, str], transport_name: str) -> None:
    assert tested.get_rmw_implementation_identifier() == transport_name
    reaches_others = transport_name != 'goalwire_memory'
    assert (transport_name in tested.get_available_rmw_implementations()) is reaches_others


def test_the_default_context_is_one_until_shutdown() -> None:
    context = tested.get_default_context()
    assert tested.get_default_context() is context
    tested.try_shutdown()
    assert tested.get_default_context() is not context

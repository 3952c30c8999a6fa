"""Processes are really started, killed and left alone here; the robot is not needed for that."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Sequence

import pytest
from helpers.patience import PATIENCE
from helpers.processes import Program
from helpers.robot import ROOT, wait_until_gone

from humanoid.supervisor import Ended, Event, Printed, StopAsked, Supervisor, ending

OBEDIENT = """
import signal, sys, threading
stop = threading.Event()
signal.signal(signal.SIGTERM, lambda *_: stop.set())
print('ready')
stop.wait()
print('stopping')
"""

TIED = 'import os; from humanoid import lifeline; lifeline.hold(os.environ)\n' + OBEDIENT

STUBBORN = """
import os, signal
signal.signal(signal.SIGTERM, signal.SIG_IGN)
print('ready')
while True:
    signal.pause()
"""


def python(text: str) -> Sequence[str]:
    return [sys.executable, '-c', text]


def wait_for(supervisor: Supervisor, wanted: Event | type[Event]) -> Event:
    deadline = time.monotonic() + PATIENCE
    while (event := supervisor.next_event(deadline)) is not None:
        if event == wanted or (isinstance(wanted, type) and isinstance(event, wanted)):
            return event
    raise AssertionError(f'{wanted} did not happen within {PATIENCE} s')


def test_what_a_child_prints_and_how_it_ends_is_told_in_order() -> None:
    with Supervisor() as supervisor:
        pid = supervisor.start('talker', python('print("one"); print("two"); raise SystemExit(3)'))
        heard = [supervisor.next_event(time.monotonic() + PATIENCE) for _ in range(3)]
    assert heard == [Printed('talker', 'one'), Printed('talker', 'two'), Ended('talker', pid, 3)]
    assert str(heard[2]) == f'talker (pid {pid}) ended with exit code 3'


def test_the_last_lines_are_kept_to_explain_a_failure() -> None:
    with Supervisor() as supervisor:
        supervisor.start('talker', python('for i in range(100): print(i)'))
        wait_for(supervisor, Ended)
        assert list(supervisor.tail('talker')) == [str(number) for number in range(80, 100)]


def test_no_event_by_the_deadline_is_none() -> None:
    with Supervisor() as supervisor:
        assert supervisor.next_event(time.monotonic() + 0.01) is None


def test_leaving_the_block_stops_a_child_in_its_own_way() -> None:
    with Supervisor() as supervisor:
        pid = supervisor.start('obedient', python(OBEDIENT))
        wait_for(supervisor, Printed('obedient', 'ready'))
    wait_for(supervisor, Printed('obedient', 'stopping'))
    assert wait_for(supervisor, Ended) == Ended('obedient', pid, 0)


@pytest.mark.slow
def test_a_child_that_does_not_stop_is_killed() -> None:
    with Supervisor() as supervisor:
        pid = supervisor.start('stubborn', python(STUBBORN))
        wait_for(supervisor, Printed('stubborn', 'ready'))
    assert wait_for(supervisor, Ended) == Ended('stubborn', pid, -signal.SIGKILL)


def test_an_exception_in_the_block_leaves_no_child_behind() -> None:
    pids: list[int] = []

    def fail() -> None:
        with Supervisor() as supervisor:
            pids.append(supervisor.start('obedient', python(OBEDIENT)))
            raise ValueError('oops')

    with pytest.raises(ValueError, match='oops'):
        fail()
    assert wait_until_gone(pids[0], 0.0)


def test_one_child_can_be_stopped_alone() -> None:
    with Supervisor() as supervisor:
        first = supervisor.start('first', python(OBEDIENT))
        second = supervisor.start('second', python(OBEDIENT))
        supervisor.stop('first')
        assert wait_until_gone(first, 0.0)
        assert not wait_until_gone(second, 0.0)


def test_a_killed_child_is_told_with_its_signal() -> None:
    with Supervisor() as supervisor:
        pid = supervisor.start('victim', python(OBEDIENT))
        wait_for(supervisor, Printed('victim', 'ready'))
        os.kill(pid, signal.SIGKILL)
        assert str(wait_for(supervisor, Ended)) == f'victim (pid {pid}) was killed by SIGKILL'


def test_handlers_are_put_back() -> None:
    before = signal.getsignal(signal.SIGINT)
    with Supervisor():
        assert signal.getsignal(signal.SIGINT) is not before
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_is_an_event_and_more_of_them_do_not_disturb_the_end(number: signal.Signals) -> None:
    before = [(each, signal.getsignal(each)) for each in (signal.SIGINT, signal.SIGTERM)]
    try:
        with Supervisor() as supervisor:
            os.kill(os.getpid(), number)
            assert supervisor.next_event(time.monotonic() + PATIENCE) == StopAsked(number)
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGTERM)
    finally:
        for each, handler in before:
            signal.signal(each, handler)


def test_children_leave_when_the_supervisor_is_killed() -> None:
    text = f"""
        import sys
        from humanoid.supervisor import Printed, Supervisor
        with Supervisor() as supervisor:
            pid = supervisor.start('child', [sys.executable, '-c', {TIED!r}])
            while supervisor.next_event() != Printed('child', 'ready'):
                pass
            print('child', pid)
            supervisor.next_event()
    """
    env = {**os.environ, 'PYTHONPATH': str(ROOT / 'robot' / 'humanoid')}
    with Program(text, env=env) as parent:
        child = int(parent.expect(r'child (\d+)')[1])
        parent.kill()
        assert wait_until_gone(child, PATIENCE)


@pytest.mark.skipif(os.name != 'posix', reason='signals are sent to itself')
def test_a_signal_during_the_start_of_the_state_publisher_ends_both() -> None:
    text = """
        import signal, subprocess, sys
        from humanoid import robot_state_publisher

        class Interrupted(subprocess.Popen):
            def __init__(self, *arguments, **options):
                super().__init__([sys.executable, '-c', 'import time; time.sleep(600)'])
                print('child', self.pid)
                signal.raise_signal(signal.SIGTERM)

        robot_state_publisher.subprocess.Popen = Interrupted
        print('ended by', robot_state_publisher.main(['robot.urdf']))
    """
    with Program(text, env={**os.environ, 'PYTHONPATH': str(ROOT / 'robot' / 'humanoid')}) as parent:
        child = int(parent.expect(r'child (\d+)')[1])
        parent.expect(f'ended by -{int(signal.SIGTERM)}')
        assert wait_until_gone(child, PATIENCE)


def test_an_unknown_signal_has_its_number() -> None:
    assert ending(-99) == 'was killed by signal 99'

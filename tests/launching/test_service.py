"""LaunchService in a program of one's own, and what programs derive from launch's classes."""

from __future__ import annotations

import asyncio
import os
import re
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from helpers.patience import PATIENCE
from launch import Action, LaunchContext, LaunchDescription, LaunchService, Substitution
from launch.actions import (
    DeclareLaunchArgument,
    ExecuteProcess,
    GroupAction,
    LogInfo,
    OpaqueCoroutine,
    OpaqueFunction,
    RegisterEventHandler,
    SetEnvironmentVariable,
    SetLaunchConfiguration,
    TimerAction,
)
from launch.event_handlers import OnProcessExit, OnProcessIO, OnProcessStart
from launch.events import Shutdown, matches_action
from launch.events.process import ShutdownProcess, SignalProcess
from launch.frontend import Entity, Parser, expose_action, expose_substitution
from launch.launch_description_sources import get_launch_description_from_any_launch_file
from launch.substitutions import LaunchConfiguration, LocalSubstitution
from launch.utilities import perform_substitutions

from goalwire.errors import LaunchError
from goalwire.launching import output


@pytest.fixture(autouse=True)
def log_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path / 'log'))
    output.reset()
    yield tmp_path / 'log'
    output.reset()


def run(*entities: Any, **options: Any) -> tuple[int, LaunchService]:
    """Carry out entities; the exit code."""
    service = LaunchService(**options)
    service.include_launch_description(LaunchDescription(list(entities)))
    return service.run(), service


SLEEP = ['sleep', '100']


def telling(process: ExecuteProcess, started: threading.Event | asyncio.Event) -> LaunchDescription:
    """Describe a launch of a process that says when it has started."""
    tell = OnProcessStart(target_action=process, on_start=lambda event, context: started.set())
    return LaunchDescription([process, RegisterEventHandler(tell)])


def test_a_process_in_a_thread_of_its_own_is_ended_from_another() -> None:
    started = threading.Event()
    process = ExecuteProcess(cmd=SLEEP)

    service = LaunchService()
    service.include_launch_description(telling(process, started))
    codes: list[int] = []
    thread = threading.Thread(target=lambda: codes.append(service.run()))
    thread.start()
    assert started.wait(PATIENCE)
    with pytest.raises(LaunchError, match='runs already'):
        service.run()
    service.shutdown()
    thread.join(PATIENCE)
    assert codes == [0]
    assert process.return_code == -2
    assert service.shutdown() is None


def test_in_a_loop_of_the_programs_own() -> None:
    async def program() -> tuple[int, int]:
        service = LaunchService()
        process = ExecuteProcess(cmd=SLEEP)
        started = asyncio.Event()
        service.include_launch_description(telling(process, started))
        task = asyncio.ensure_future(service.run_async())
        await asyncio.wait_for(started.wait(), PATIENCE)
        waiting = service.shutdown()
        assert waiting is not None
        await waiting
        assert process.return_code is not None
        return await task, process.return_code

    assert asyncio.run(program()) == (0, -2)


def test_a_cancelled_task_ends_its_processes() -> None:
    process = ExecuteProcess(cmd=SLEEP)

    async def program() -> None:
        service = LaunchService()
        started = asyncio.Event()
        service.include_launch_description(telling(process, started))
        task = asyncio.ensure_future(service.run_async())
        await asyncio.wait_for(started.wait(), PATIENCE)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    asyncio.run(program())
    assert process.return_code == -2


def test_events_from_outside_end_one_process() -> None:
    process = ExecuteProcess(cmd=SLEEP)
    seen: list[int] = []

    def ended(event: Any, context: LaunchContext) -> None:
        seen.append(event.returncode)

    def emit(context: LaunchContext) -> None:
        context.emit_event_sync(ShutdownProcess(process_matcher=matches_action(process)))

    ask = TimerAction(period=0.1, actions=[OpaqueFunction(function=emit)])

    code, _ = run(process, RegisterEventHandler(OnProcessExit(on_exit=ended)), ask)
    assert (code, seen) == (0, [-2])


def test_a_signal_by_name_or_number() -> None:
    assert SignalProcess(signal_number='SIGUSR1', process_matcher=bool).signal_name == 'SIGUSR1'
    with pytest.raises(ValueError, match='SIGNOTHING'):
        SignalProcess(signal_number='SIGNOTHING', process_matcher=bool)


def test_without_shutdown_when_idle_it_waits_for_more() -> None:
    service = LaunchService()
    codes: list[int] = []
    thread = threading.Thread(target=lambda: codes.append(service.run(shutdown_when_idle=False)))
    thread.start()
    seen = threading.Event()
    service.include_launch_description(
        LaunchDescription([OpaqueFunction(function=lambda context: seen.set())])
    )
    assert seen.wait(PATIENCE)
    assert thread.is_alive()
    service.emit_event(Shutdown(reason='enough'))
    thread.join(PATIENCE)
    assert codes == [0]


def test_cached_output_and_the_names_of_processes(capfd: pytest.CaptureFixture[str]) -> None:
    process = ExecuteProcess(cmd=['sh', '-c', 'echo one; echo two >&2; printf three'], cached_output=True)
    code, _ = run(process, RegisterEventHandler(OnProcessIO(on_stderr=lambda event: LogInfo(msg='heard'))))
    assert code == 0
    assert process.get_stdout() == 'one\nthree'
    assert process.get_stderr() == 'two\n'
    shown = capfd.readouterr().out
    assert '] two' in shown
    assert 'one' not in shown
    assert 'heard' in shown


def test_a_line_without_end_fills_no_memory(capfd: pytest.CaptureFixture[str]) -> None:
    run(
        ExecuteProcess(
            cmd=['sh', '-c', 'head -c 200000 /dev/zero | tr "\\0" x'], output='screen', name='long'
        )
    )
    lines = [line for line in capfd.readouterr().out.splitlines() if 'xx' in line]
    assert len(lines) > 1
    assert sum(line.count('x') for line in lines) == 200000


def test_ctrl_c_while_a_process_waits_to_be_respawned() -> None:
    process = ExecuteProcess(cmd=['true'], respawn=True, respawn_delay=1000.0)
    stop = RegisterEventHandler(OnProcessExit(on_exit=lambda event, context: end(context)))
    code, _ = run(process, stop)
    assert (code, process.return_code) == (0, 0)


def test_names_and_prefixes(capfd: pytest.CaptureFixture[str]) -> None:
    run(
        ExecuteProcess(cmd=['/bin/echo four | cat'], shell=True, output='screen'),
        SetLaunchConfiguration('launch-prefix', 'env'),
        SetLaunchConfiguration('launch-prefix-filter', 'ec'),
        ExecuteProcess(cmd=['echo', 'one'], output='screen'),
        ExecuteProcess(cmd=['printf', 'two'], output='screen'),
        ExecuteProcess(cmd=['printf', 'three'], prefix='env', output='screen'),
    )
    shown = re.sub(r'-\d+\]', ']', capfd.readouterr().out)
    assert {'[env] one', '[printf] two', '[env] three', '[echo] four'} <= set(shown.splitlines())


def test_scopes_end_with_their_group() -> None:
    seen: dict[str, Any] = {}

    def look(context: LaunchContext, name: str) -> None:
        seen[name] = (context.launch_configurations.get('a'), os.environ.get('DEMO_SCOPE'))

    def at(name: str) -> OpaqueFunction:
        return OpaqueFunction(function=look, args=[name])

    run(
        SetLaunchConfiguration('a', 'outer'),
        GroupAction(
            [SetLaunchConfiguration('a', 'inner'), SetEnvironmentVariable('DEMO_SCOPE', 'inner'), at('group')]
        ),
        at('after'),
        GroupAction([at('forgotten')], forwarding=False, launch_configurations={'b': '1'}),
        GroupAction([SetLaunchConfiguration('a', 'leaked')], scoped=False),
        at('end'),
    )
    assert seen == {
        'group': ('inner', 'inner'),
        'after': ('outer', None),
        'forgotten': (None, None),
        'end': ('leaked', None),
    }


def test_a_coroutine_runs_in_the_loop_and_ends_with_the_launch() -> None:
    steps: list[str] = []

    async def work(context: LaunchContext, name: str) -> None:
        try:
            steps.append(name)
            await asyncio.sleep(100)
        finally:
            steps.append('ended')

    code, _ = run(
        OpaqueCoroutine(coroutine=work, args=['begun']),
        TimerAction(period=0.05, actions=[OpaqueFunction(function=end)]),
    )

    assert code == 0
    assert steps == ['begun', 'ended']


def end(context: LaunchContext) -> None:
    context.emit_event_sync(Shutdown())


def test_an_error_gives_one(capfd: pytest.CaptureFixture[str]) -> None:
    code, _ = run(LogInfo(msg=LocalSubstitution('event.pid')))
    assert code == 1
    assert f'{__file__}:' in capfd.readouterr().out


def test_actions_and_substitutions_of_ones_own_in_xml(tmp_path: Path) -> None:
    made: list[str] = []

    @expose_action('shout')
    class Shout(Action):
        def __init__(self, *, text: Any, times: int = 1, **options: Any) -> None:
            super().__init__(**options)
            self._text = text
            self._times = times

        @classmethod
        def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
            _, arguments = super().parse(entity, parser)
            arguments['text'] = parser.parse_substitution(entity.get_attr('text'))
            arguments['times'] = entity.get_attr('times', data_type=int, optional=True) or 1
            return cls, arguments

        def execute(self, context: LaunchContext) -> None:
            made.append(perform_substitutions(context, self._text) * self._times)

    @expose_substitution('upper')
    class Upper(Substitution):
        def __init__(self, text: Any) -> None:
            self._text = text

        @classmethod
        def parse(cls, data: Sequence[Any]) -> tuple[type[Substitution], dict[str, Any]]:
            return cls, {'text': data[0]}

        def perform(self, context: LaunchContext) -> str:
            return perform_substitutions(context, self._text).upper()

    file = tmp_path / 'own.launch.xml'
    file.write_text('<launch><let name="a" value="x"/><shout text="$(upper $(var a))!" times="2"/></launch>')
    code, _ = run(*get_launch_description_from_any_launch_file(str(file)).entities)
    assert (code, made) == (0, ['X!X!'])


def test_arguments_are_declared_once(tmp_path: Path) -> None:
    description = LaunchDescription(
        [DeclareLaunchArgument('a', default_value=LaunchConfiguration('b', default='c')), LogInfo(msg='x')]
    )
    assert [argument.name for argument in description.get_launch_arguments()] == ['a']

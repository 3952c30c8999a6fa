"""rviz2 and rqt: their names open a page of the console, or the real program if there is one."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from apps.programs.conftest import Run
from helpers.processes import Program

from goalwire.apps.console.settings import VIEWS
from goalwire.apps.programs.console_pages import PAGES, split_options
from goalwire.launching.source_programs import interpreter_lines


def test_every_page_that_a_program_opens_is_there() -> None:
    assert {view for view, _ in PAGES.values()} <= {*VIEWS, ''}


def test_the_views_of_the_settings_are_those_of_the_page() -> None:
    pytest.importorskip('nicegui')
    from goalwire.apps.console.page.shell import VIEWS as SHOWN

    assert tuple(kind.name for kind in SHOWN) == VIEWS


def test_options_of_the_console_are_passed_on_and_others_told() -> None:
    words = ['-d', 'view.rviz', '--port', '0', '--host=::1', '--no-open', '-s']
    assert split_options(words) == (
        ['--port', '0', '--host=::1', '--no-open'],
        ['-d', 'view.rviz', '-s'],
    )


def test_a_page_is_opened_and_named(run: Run) -> None:
    pytest.importorskip('nicegui')
    program = run(
        'rviz2', 'rviz2', '-d', 'view.rviz', '--port', '0', '--no-open', '--ros-args', '-r', '__node:=rviz'
    )
    program.expect('rviz2: goalwire console does this: its page Robot')
    program.expect(r'the console is at http://localhost:\d+/\?view=robot;')
    assert 'rviz2: not read: -d view.rviz' in program.output


def test_the_program_of_a_ros2_is_started_in_its_place(isolated: dict[str, str], tmp_path: Path) -> None:
    real = tmp_path / 'bin' / 'rviz2'
    real.parent.mkdir()
    first = interpreter_lines(sys.executable)
    real.write_text(f'{first}\nimport sys\nprint("the real one", *sys.argv[1:])\n')
    real.chmod(0o755)
    call = 'from goalwire.apps.programs.console_pages import rviz2; rviz2()'
    for env in (
        {'AMENT_PREFIX_PATH': str(tmp_path)},
        {'PATH': f'{real.parent}{os.pathsep}{isolated["PATH"]}'},
    ):
        with Program(call, '-d', 'view.rviz', env=isolated | env) as program:
            assert 'the real one -d view.rviz' in program.succeed()

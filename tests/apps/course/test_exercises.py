"""The material of the exercises, and the commands that hand it out."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.command_line import CommandLine
from helpers.isolation import isolated_env
from helpers.markdown import ROOT

from goalwire.apps.course.exercises import EXERCISES, INTERFACES, MATERIAL, Exercise, start

BY_NUMBER = pytest.mark.parametrize('exercise', EXERCISES, ids=lambda exercise: exercise.name)


def test_the_interfaces_are_those_of_the_robot() -> None:
    """So that a student's client moves the humanoid, too. The robot may have more than the course needs."""
    definitions = [file for kind in ('srv', 'action') for file in (MATERIAL / INTERFACES / kind).iterdir()]
    assert len(definitions) == 4
    for file in definitions:
        of_robot = ROOT / 'robot' / INTERFACES / file.parent.name / file.name
        assert file.read_text(encoding='utf-8') == of_robot.read_text(encoding='utf-8'), file.name


@BY_NUMBER
def test_an_exercise_has_a_task_a_beginning_hints_and_a_solution(exercise: Exercise) -> None:
    assert f'goalwire course check {exercise.number}' in exercise.read('task.md')
    for program in ('start.py', 'solution.py'):
        compile(exercise.read(program), program, 'exec')
    assert len(exercise.hints()) >= 5
    assert all(hint.endswith(('.', '?')) for hint in exercise.hints())


def test_start_makes_a_folder_with_all_that_the_program_needs(tmp_path: Path) -> None:
    files = start(EXERCISES[1], tmp_path)
    assert {file.relative_to(tmp_path / 'exercise_2').as_posix() for file in files} >= {
        'README.md',
        'arm_server.py',
        'humanoid_interfaces/package.xml',
        'humanoid_interfaces/action/MoveArm.action',
    }


def test_start_leaves_a_students_work_alone(tmp_path: Path) -> None:
    start(EXERCISES[0], tmp_path)
    work = tmp_path / 'exercise_1' / 'battery_service.py'
    work.write_text('# mine\n')
    with pytest.raises(FileExistsError):
        start(EXERCISES[0], tmp_path)
    assert work.read_text() == '# mine\n'


class TestCommands:
    """`goalwire course`, as it is typed."""

    @pytest.fixture
    def goalwire(self, tmp_path: Path) -> CommandLine:
        return CommandLine(isolated_env('rmw_zenoh_cpp'), tmp_path)

    def test_it_lists_the_exercises(self, goalwire: CommandLine) -> None:
        lines = goalwire.ok('course', 'list', '--json', program='goalwire').splitlines()
        assert [json.loads(line)['number'] for line in lines] == [1, 2, 3, 4]

    def test_hints_come_one_at_a_time_and_end_with_the_solution(self, goalwire: CommandLine) -> None:
        assert goalwire.ok('course', 'hint', '4').startswith('1 of 5: ')
        assert 'next: goalwire course hint 4 3' in goalwire.ok('course', 'hint', '4', '2')
        assert goalwire.ok('course', 'hint', '4', '5').count('\n') == 1
        assert 'goalwire course solution 4' in goalwire.fails('course', 'hint', '4', '6', code=3)

    def test_what_is_not_there_is_said_in_one_line(self, goalwire: CommandLine) -> None:
        assert 'choose 1 to 4' in goalwire.fails('course', 'solution', '5', code=3)
        assert 'goalwire course start 3' in goalwire.fails('course', 'check', '3', code=3)
        goalwire.ok('course', 'start', '3')
        assert 'stays as it is' in goalwire.fails('course', 'start', '3', code=1)

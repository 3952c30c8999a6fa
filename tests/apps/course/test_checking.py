"""The checks of the exercises: the solutions pass, and each wrong program is told what is wrong with it.

The programs run as processes of their own, as a student's do. A wrong one is the solution with one mistake.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

from goalwire.apps.course.checking import Report, check
from goalwire.apps.course.checks.reliable_client import judge_pauses
from goalwire.apps.course.exercises import EXERCISES, Exercise
from goalwire.apps.course.student import Wrong


class Mistake(NamedTuple):
    """A mistake in a program: `right` of the solution is `wrong` there; `told` is in what is said."""

    name: str
    right: str
    wrong: str
    told: str


MISTAKES = {
    'battery_service': [
        Mistake('another name', "'get_battery_status'", "'battery'", '/battery (humanoid_interfaces'),
        Mistake(
            'another type',
            "GetBatteryStatus, 'get_battery_status', self.answer",
            "Trigger, 'get_battery_status', lambda request, response: response",
            'has the type std_srvs/srv/Trigger',
        ),
        Mistake('no return', '        return response\n', '', 'it returned None'),
        Mistake(
            'an error', 'response.battery = state', 'response.batery = state', "has no attribute 'batery'"
        ),
        Mistake('a type', 'state.charge = charge', "state.charge = 'full'", 'battery.charge: expected float'),
        Mistake(
            'slow',
            'charge = self.battery.charge()',
            'charge = self.battery.charge(); time.sleep(3)',
            'no answer came',
        ),
        Mistake(
            'percent',
            '= charge / Battery.CAPACITY',
            '= 100.0 * charge / Battery.CAPACITY',
            'battery.percentage is',
        ),
        Mistake('the sign', '= -Battery.CURRENT', '= Battery.CURRENT', 'current is 2 A'),
        Mistake('a frozen battery', "float('nan')", '0.0', '0 degrees'),
        Mistake('no stamp', 'state.header.stamp = self', 'self.now = self', 'header.stamp is empty'),
        Mistake(
            'minutes', '* 3600.0)\n        return', '* 60.0)\n        return', 'but charge / current says'
        ),
        Mistake(
            'measured once',
            'hours = (time.monotonic() - self._began) / 3600.0',
            'hours = 0.0',
            'charge is still the same',
        ),
        Mistake('no spin', 'rclpy.spin(node)', 'node.destroy_node()', 'ended with exit code 0'),
        Mistake('a syntax error', 'def main():', 'def main()', 'ended with exit code 1'),
        Mistake(
            'an answer of its own',
            '        return response\n',
            '        return GetBatteryStatus.Response()\n',
            'the battery in the answer is empty\nset the fields of the battery',
        ),
        Mistake(
            'request and response swapped',
            'def answer(self, request, response)',
            'def answer(self, response, request)',
            "'GetBatteryStatus_Request' object has no attribute 'battery'",
        ),
        Mistake(
            'no request',
            'def answer(self, request, response)',
            'def answer(self, response)',
            'def answer(self, request, response)',
        ),
        Mistake(
            'called at once',
            ', self.answer)',
            ', self.answer())',
            'BatteryService.answer() missing 2 required positional arguments',
        ),
        Mistake(
            'a float',
            'int(charge / Battery.CURRENT * 3600.0)',
            'charge / Battery.CURRENT * 3600.0',
            'time_remaining.sec: expected int',
        ),
        Mistake(
            'no base class', "        super().__init__('battery_service')\n", '', 'must call super().__init__'
        ),
    ],
    'arm_server': [
        Mistake(
            'accepts all',
            'GoalResponse.ACCEPT if good else GoalResponse.REJECT',
            'GoalResponse.ACCEPT',
            'names no joint is accepted',
        ),
        Mistake(
            'refuses all',
            'GoalResponse.ACCEPT if good else GoalResponse.REJECT',
            'GoalResponse.REJECT',
            'a good goal is refused',
        ),
        Mistake(
            'no limits',
            'LIMITS[name][0] <= position <= LIMITS[name][1]',
            'position == position',
            'beyond the limits',
        ),
        Mistake(
            'NaN passes',
            'LIMITS[name][0] <= position <= LIMITS[name][1]',
            'not (position < LIMITS[name][0] or position > LIMITS[name][1])',
            'NaN for a position is accepted\nevery comparison with NaN is false',
        ),
        Mistake(
            'no feedback', '            goal_handle.publish_feedback(feedback)\n', '', '0 feedback messages'
        ),
        Mistake(
            'percent', 'fraction_done=fraction', 'fraction_done=100.0 * fraction', 'fraction_done goes from'
        ),
        Mistake('no succeed', '        goal_handle.succeed()\n', '', 'a good goal ends ABORTED'),
        Mistake(
            'an empty result',
            "return self.result(goal, True, 'arrived')",
            'return MoveArm.Result(success=True)',
            'final_positions is []',
        ),
        Mistake(
            'an error',
            'goal_handle.publish_feedback(feedback)',
            'goal_handle.publish(feedback)',
            "'ServerGoalHandle' object has no attribute 'publish'",
        ),
        Mistake(
            'an error in goal_callback',
            'len(goal.joint_names) > 0',
            'len(goal.joints) > 0',
            "has no attribute 'joints'",
        ),
        Mistake('no self', '            self,\n', '', 'the first argument of ActionServer is the node'),
        Mistake(
            'ten steps',
            'fraction = min((time.monotonic() - began) / goal.duration, 1.0)',
            'fraction = min(fraction + 0.1, 1.0)',
            'a goal of 1.5 s ended after',
        ),
        Mistake('jumps', 'min((time.monotonic() - began) / goal.duration, 1.0)', '1.0', 'ended after 0.'),
        Mistake(
            'refuses to cancel',
            'return CancelResponse.ACCEPT',
            'return CancelResponse.REJECT',
            'refuses to cancel',
        ),
        Mistake('one thread', ', executor=MultiThreadedExecutor()', '', 'to cancel was not answered'),
        Mistake('never looks', 'if goal_handle.is_cancel_requested:', 'if False:', 'still runs'),
        Mistake('abort', 'goal_handle.canceled()', 'goal_handle.abort()', 'a cancelled goal ends ABORTED'),
        Mistake(
            'success',
            "self.result(goal, False, 'stopped on the way')",
            "self.result(goal, True, 'stopped')",
            'has success=True',
        ),
        Mistake(
            'from zero',
            'begin = [self.positions[name] for name in goal.joint_names]',
            'begin = [0.0 for name in goal.joint_names]',
            'the next goal begins at',
        ),
        Mistake('another action', "'move_arm'", "'arm'", "serves no action 'move_arm'; it serves: /arm"),
        Mistake(
            'one joint of two',
            '[self.positions[name] for name in goal.joint_names]\n            goal',
            '[0.0]\n            goal',
            'and 1 positions',
        ),
        Mistake('one step', 'time.sleep(STEP)', 'time.sleep(goal.duration)', '1 feedback messages came'),
        Mistake(
            'a lost result',
            "return self.result(goal, True, 'arrived')",
            "self.result(goal, True, 'arrived')",
            'its result has success=False',
        ),
        Mistake(
            'lengths',
            '            and len(goal.joint_names) == len(goal.positions)\n',
            '',
            'two joints and one position is accepted',
        ),
        Mistake(
            'a bool',
            'return GoalResponse.ACCEPT if good else GoalResponse.REJECT',
            'return good',
            'a good goal is refused',
        ),
        Mistake(
            'no canceled', '                goal_handle.canceled()\n', '', 'a cancelled goal ends ABORTED'
        ),
    ],
    'mission_client': [
        Mistake(
            'spins on',
            '    arrived = node.run()\n',
            '    arrived = node.run()\n    rclpy.spin(node)\n',
            'has not ended',
        ),
        Mistake(
            'no service', 'charge = self.ask_for_charge()', 'charge = 1.0', 'without asking for the battery'
        ),
        Mistake('no goal', 'goal_handle = self.send_goal()', 'return True', 'and the program sent no goal'),
        Mistake('percent of 100', 'charge < LEAST_CHARGE', 'charge < 20', 'the battery was at 80%'),
        Mistake(
            'a wait whose end is ignored',
            'self.battery.wait_for_service()',
            'self.battery.wait_for_service(timeout_sec=0.1)',
            'has not ended',
        ),
        Mistake('no wait for the arm', '        self.arm.wait_for_server()\n', '', 'has not ended'),
        Mistake(
            'never looks at accepted',
            'if not goal_handle.accepted:',
            'if False:',
            'asks for its result',
        ),
        Mistake(
            'cancels and leaves',
            'rclpy.spin_until_future_complete(self, goal_handle.cancel_goal_async(), timeout_sec=LIMIT)',
            'goal_handle.cancel_goal_async()',
            'before the arm had answered',
        ),
        Mistake('no feedback', ', feedback_callback=self.show', '', 'did not show it'),
        Mistake('a part of 1', 'fraction_done:.0%', 'fraction_done', 'did not show it'),
        Mistake('an empty battery', 'charge < LEAST_CHARGE', 'charge < 0.0', 'was moved although'),
        Mistake('always 0', 'sys.exit(0 if arrived else 1)', 'sys.exit(0)', 'and the exit code is 0'),
        Mistake(
            'refused',
            '            return False\n        return self.follow',
            '            return True\n        return self.follow',
            'the arm refuses the goal, and the exit code is 0',
        ),
        Mistake(
            'aborted',
            'return answer.status == GoalStatus.STATUS_SUCCEEDED',
            'return True',
            'ends ABORTED, and the exit code is 0',
        ),
        Mistake('no limit', 'future, timeout_sec=LIMIT)', 'future)', 'has not ended'),
        Mistake(
            'no cancel',
            'rclpy.spin_until_future_complete(self, goal_handle.cancel_goal_async(), timeout_sec=LIMIT)',
            'pass',
            'the arm still moves',
        ),
        Mistake(
            'never spun',
            '        rclpy.spin_until_future_complete(self, future)\n        return future.result().battery',
            '        return future.result().battery',
            "'NoneType' object has no attribute 'battery'",
        ),
        Mistake(
            'call',
            'self.battery.call_async(',
            'self.battery.call(',
            'give the future that call_async() returns',
        ),
        Mistake(
            'goal first',
            '        charge = self.ask_for_charge()\n',
            '        self.send_goal()\n        charge = self.ask_for_charge()\n',
            'before the battery was known',
        ),
        Mistake(
            'the message of feedback',
            'message.feedback.fraction_done',
            'message.fraction_done',
            "has no attribute 'fraction_done'",
        ),
        Mistake('no list', 'positions=[1.0]', 'positions=1.0', 'write positions=[1.0]'),
        Mistake(
            'two goals',
            'return self.follow(goal_handle)',
            'self.send_goal()\n        return self.follow(goal_handle)',
            '2 goals were sent',
        ),
        Mistake(
            'another status',
            '== GoalStatus.STATUS_SUCCEEDED',
            '== 1',
            'all went well, but the exit code is 1',
        ),
    ],
    'reliable_client': [
        Mistake('no limit', ', timeout_sec=ANSWERS_WITHIN', '', 'has not ended'),
        Mistake('no server', '(timeout_sec=2.0)', '()', 'has not ended'),
        Mistake('once', 'ATTEMPTS = 4', 'ATTEMPTS = 1', 'the exit code is 1'),
        Mistake('five times', 'ATTEMPTS = 4', 'ATTEMPTS = 5', '5 requests came instead of 4'),
        Mistake('the same pause', '                pause *= 2\n', '', 'after one another'),
        Mistake('no pause', 'time.sleep(pause)', 'time.sleep(0.0)', 'after one another'),
        Mistake('always 0', 'sys.exit(1)', 'sys.exit(0)', 'and the exit code is 0'),
        Mistake(
            'asks on',
            'return answer.battery.percentage',
            'charge = answer.battery.percentage',
            'and the exit code is 1',
        ),
        Mistake(
            'an exception',
            "    if charge is None:\n        print('the battery could not be asked')\n        sys.exit(1)\n",
            '',
            'exception',
        ),
        Mistake('three attempts', 'ATTEMPTS = 4', 'ATTEMPTS = 3', '3 requests came instead of 4'),
        Mistake(
            'no request',
            'GetBatteryStatus.Request()',
            'GetBatteryStatus()',
            'write GetBatteryStatus.Request()',
        ),
        Mistake(
            'once more',
            'return answer.battery.percentage',
            'self.try_once()\n                return answer.battery.percentage',
            '2 requests came instead of 1',
        ),
        Mistake('a part of 1', '{charge:.0%}', '{charge}', 'does not show it'),
        Mistake('shorter pauses', 'pause *= 2', 'pause /= 2', 'the pauses do not grow'),
        Mistake('a thousand times', 'ATTEMPTS = 4', 'ATTEMPTS = 1000', 'requests came until then'),
    ],
}
"""The mistakes of each exercise."""
ALL = [(exercise, mistake) for exercise in EXERCISES for mistake in MISTAKES[exercise.name]]


@pytest.mark.parametrize(
    'gaps', [(0.70, 0.90, 1.10), (0.87, 0.90, 1.10), (0.75, 0.92, 1.30)], ids=['even', 'late', 'doubled']
)
def test_pauses_that_grow_evenly_are_enough(gaps: tuple[float, ...]) -> None:
    """Also if the first gap is longer than its pause, as on a busy machine."""
    judge_pauses(gaps)


@pytest.mark.parametrize(
    ('gaps', 'told'),
    [
        ((0.78, 0.70, 0.70), 'the pauses do not grow'),
        ((0.90, 0.80, 0.60), 'the pauses do not grow'),
        ((0.55, 0.50, 0.50), 'there is no pause between attempts'),
    ],
)
def test_pauses_that_do_not_grow_are_told_from_none_at_all(gaps: tuple[float, ...], told: str) -> None:
    with pytest.raises(Wrong, match=told):
        judge_pauses(gaps)


def _check_wrong(exercise: Exercise, mistake: Mistake, folder: Path) -> Report:
    solution = exercise.read('solution.py')
    assert mistake.right in solution
    text = solution.replace(mistake.right, mistake.wrong)
    if 'Trigger' in text:
        text = f'from std_srvs.srv import Trigger\n{text}'
    file = folder / exercise.program
    file.write_text(text, encoding='utf-8')
    return check(exercise, file)


@pytest.mark.slow
@pytest.mark.parametrize('exercise', EXERCISES, ids=lambda exercise: exercise.name)
def test_the_solution_passes(exercise: Exercise, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / exercise.program
    file.write_text(exercise.read('solution.py'), encoding='utf-8')
    told: list[str] = []
    report = check(exercise, file, told.append)
    assert (report.problem, report.advice) == ('', '')
    assert told == report.passed
    assert capfd.readouterr() == ('', '')  # nothing but what the command tells


def _names(value: object) -> str:
    return value.name.replace(' ', '-') if isinstance(value, (Exercise, Mistake)) else ''


@pytest.mark.slow
@pytest.mark.parametrize(('exercise', 'mistake'), ALL[:3], ids=_names)
def test_a_wrong_program_is_told_what_is_wrong(exercise: Exercise, mistake: Mistake, tmp_path: Path) -> None:
    report = _check_wrong(exercise, mistake, tmp_path)
    assert report.advice
    assert mistake.told in f'{report.problem}\n{report.advice}'


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(('exercise', 'mistake'), ALL[3:], ids=_names)
def test_each_mistake_is_told(exercise: Exercise, mistake: Mistake, tmp_path: Path) -> None:
    test_a_wrong_program_is_told_what_is_wrong(exercise, mistake, tmp_path)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize('exercise', EXERCISES, ids=lambda exercise: exercise.name)
def test_the_file_to_begin_with_is_not_enough(exercise: Exercise, tmp_path: Path) -> None:
    file = tmp_path / exercise.program
    file.write_text(exercise.read('start.py'), encoding='utf-8')
    report = check(exercise, file)
    assert report.problem
    assert FIRST_MESSAGES[exercise.name] in report.problem


FIRST_MESSAGES = {
    'battery_service': "serves no service 'get_battery_status'; it serves: none",
    'arm_server': "serves no action 'move_arm'; it serves: none",
    'mission_client': 'without asking for the battery',
    'reliable_client': 'has not ended',
}
"""The message of each exercise to everybody who checks before the work has begun."""


@pytest.mark.slow
def test_an_action_that_is_not_there_is_not_mistaken_for_the_checks_own_client(tmp_path: Path) -> None:
    exercise = EXERCISES[1]
    file = tmp_path / exercise.program
    file.write_text(exercise.read('start.py'), encoding='utf-8')
    report = check(exercise, file)
    assert report.problem == f'the program {FIRST_MESSAGES[exercise.name]}'
    assert report.advice.startswith('make the ActionServer in __init__ (step 1)')


@pytest.mark.slow
def test_an_exception_is_told_with_the_line_that_raised_it(tmp_path: Path) -> None:
    exercise = EXERCISES[0]
    text = exercise.read('solution.py').replace('state.present = True', "raise ValueError('too hot')")
    line = text.splitlines().index("        raise ValueError('too hot')") + 1
    file = tmp_path / exercise.program
    file.write_text(text, encoding='utf-8')
    report = check(exercise, file)
    assert report.problem.endswith('ValueError: too hot')
    assert report.advice == f"battery_service.py, line {line}: raise ValueError('too hot')"

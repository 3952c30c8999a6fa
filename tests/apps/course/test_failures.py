"""The contents of a traceback in a student's output: the exception, the line, and the hints after it."""

from __future__ import annotations

from goalwire.apps.course.failures import find_failure

RAISED = """[INFO] ready
Traceback (most recent call last):
  (9 frames of goalwire are not shown: GOALWIRE_FULL_TRACEBACKS=1 shows them)
  File "/home/me/arm.py", line 79, in <module>
    main()
  File "/home/me/arm.py", line 73, in main
    rclpy.spin(node)
  {}goalwire.errors.EncodeTypeError: charge: expected float
  it has the fields charge, current
[INFO] over
"""
CALLBACK = 'File "/home/me/arm.py", line 32, in judge\n    len(goal.joint_name) > 0\n        ^^^^\n'


def test_it_names_the_exception_the_line_and_the_hint() -> None:
    failure = find_failure(RAISED.format(CALLBACK), 'arm.py')
    assert failure is not None
    assert failure.text == 'EncodeTypeError: charge: expected float'
    assert failure.advice.splitlines() == [
        'arm.py, line 32: len(goal.joint_name) > 0',
        '       it has the fields charge, current',
    ]


def test_a_line_that_spins_is_not_blamed_for_a_callback() -> None:
    failure = find_failure(RAISED.replace('  {}', ''), 'arm.py')
    assert failure is not None
    assert failure.advice == 'it has the fields charge, current'


def test_output_without_a_traceback_has_no_failure() -> None:
    assert find_failure('Traceback is a word\n', 'arm.py') is None
    assert find_failure('Traceback (most recent call last):\n  File "arm.py", line 1\n', 'arm.py') is None

"""goalwire course: its verbs. The module of a verb is imported when the verb runs."""

from __future__ import annotations

from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

NOUN = Noun(
    'course',
    'Learn services and actions: exercises, and checks of your work',
    (
        Verb(
            'check',
            'Run and test your program, and print the first mistake',
            *lazy('course.exercises', 'check_program'),
        ),
        Verb('hint', 'Print a hint for an exercise', *lazy('course.exercises', 'show_hint')),
        Verb('list', 'List the exercises', *lazy('course.exercises', 'list_exercises')),
        Verb('solution', 'Print a solution', *lazy('course.exercises', 'show_solution'), has_json=False),
        Verb(
            'start',
            'Make a folder with the task and a file to begin with',
            *lazy('course.exercises', 'start_exercise'),
        ),
    ),
)

"""goalwire course: its verbs. Each has a module in this folder, imported when the verb runs."""

from __future__ import annotations

from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

NOUN = Noun(
    'course',
    'Learn services and actions: exercises, and checks of your work',
    (
        Verb('check', 'Run and test your program, and print the first mistake', *lazy('course.check')),
        Verb('hint', 'Print a hint for an exercise', *lazy('course.hint')),
        Verb('list', 'List the exercises', *lazy('course.list')),
        Verb('solution', 'Print a solution', *lazy('course.solution'), has_json=False),
        Verb('start', 'Make a folder with the task and a file to begin with', *lazy('course.start')),
    ),
)

"""goalwire course: its verbs; each has a module beside this one, which is imported when it is run."""

from __future__ import annotations

from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

NOUN = Noun(
    'course',
    'Learn services and actions: exercises, and checks of your work',
    (
        Verb('check', 'Run your program, try it, and say what is not as it should be', *lazy('course.check')),
        Verb('hint', 'Print a hint for an exercise', *lazy('course.hint')),
        Verb('list', 'List the exercises', *lazy('course.list')),
        Verb('solution', 'Print a solution', *lazy('course.solution'), has_json=False),
        Verb('start', 'Make a folder with the task and a file to begin with', *lazy('course.start')),
    ),
)

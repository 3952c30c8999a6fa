"""goalwire mission: its verbs; each has a module beside this one, which is imported when it is run."""

from __future__ import annotations

from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

NOUN = Noun(
    'mission',
    'Run missions that go on after a crash, and answer their questions',
    (
        Verb('approve', 'Answer the question of a mission: yes or no', *lazy('mission.approve')),
        Verb('cancel', 'Stop a mission: cancel its goal, undo what it did', *lazy('mission.cancel')),
        Verb('check', "Say whether a file's missions fit their journals", *lazy('mission.check')),
        Verb('decide', 'Say whether a step that may have happened did', *lazy('mission.decide')),
        Verb('history', 'Print the journal of a mission', *lazy('mission.history')),
        Verb('list', 'Output a list of missions', *lazy('mission.list')),
        Verb('pause', 'Let a mission begin no further step', *lazy('mission.pause')),
        Verb('resume', 'Let a mission go on that is paused, held or stuck', *lazy('mission.resume')),
        Verb('run', 'Begin a mission, or go on with it, and follow it', *lazy('mission.run')),
        Verb('show', 'Print how a mission stands, and what it asks', *lazy('mission.show')),
    ),
)

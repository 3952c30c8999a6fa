"""goalwire mission: its verbs. The module of a verb is imported when the verb runs."""

from __future__ import annotations

from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

NOUN = Noun(
    'mission',
    'Run missions that go on after a crash, and answer their questions',
    (
        Verb('approve', 'Answer the question of a mission: yes or no', *lazy('mission.orders', 'approve')),
        Verb(
            'cancel', 'Stop a mission: cancel its goal, undo what it did', *lazy('mission.orders', 'cancel')
        ),
        Verb('check', "Say whether a file's missions fit their journals", *lazy('mission.check')),
        Verb('decide', 'Say whether an uncertain step has happened', *lazy('mission.orders', 'decide')),
        Verb('history', 'Print the journal of a mission', *lazy('mission.looking', 'show_history')),
        Verb('list', 'Output a list of missions', *lazy('mission.looking', 'list_missions')),
        Verb('pause', 'Pause a mission before its next step', *lazy('mission.orders', 'pause')),
        Verb('resume', 'Continue a mission that is paused, held or stuck', *lazy('mission.orders', 'resume')),
        Verb('run', 'Begin a mission, or go on with it, and follow it', *lazy('mission.run')),
        Verb(
            'show',
            'Print the state of a mission and its open question',
            *lazy('mission.looking', 'show_mission'),
        ),
    ),
)

"""goalwire fleet: its verbs. The module of a verb is imported when the verb runs."""

from __future__ import annotations

from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

NOUN = Noun(
    'fleet',
    'See and command many robots, and connect them',
    (
        Verb(
            'init',
            'Write the settings of a site router or of a cloud router',
            *lazy('fleet.routers', 'write_router'),
        ),
        Verb(
            'join', 'Write the settings of a robot or of an operator', *lazy('fleet.routers', 'write_member')
        ),
        Verb('list', 'List the robots that are there', *lazy('fleet.looking', 'list_robots')),
        Verb('send', 'Send one goal to many robots', *lazy('fleet.send')),
        Verb('status', 'Show state, battery and goals of each robot', *lazy('fleet.looking', 'show_status')),
    ),
)

"""goalwire fleet: its verbs. Each has a module in this folder, imported when the verb runs."""

from __future__ import annotations

from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

NOUN = Noun(
    'fleet',
    'See and command many robots, and connect them',
    (
        Verb('init', 'Write the settings of a site router or of a cloud router', *lazy('fleet.init')),
        Verb('join', 'Write the settings of a robot or of an operator', *lazy('fleet.join')),
        Verb('list', 'List the robots that are there', *lazy('fleet.list')),
        Verb('send', 'Send one goal to many robots', *lazy('fleet.send')),
        Verb('status', 'Show state, battery and goals of each robot', *lazy('fleet.status')),
    ),
)

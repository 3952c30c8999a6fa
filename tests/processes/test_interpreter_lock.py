"""An extension in C holds the interpreter's lock for 20 s: its program is slow meanwhile, and not dead."""

from __future__ import annotations

import pytest
from helpers.programs import Start

pytestmark = [pytest.mark.slow, pytest.mark.timeout(180)]

HELD_S = 20
"""More than the time after which a link says that it lives, 15 s of the lease of 60 s."""


def test_who_holds_the_interpreters_lock_loses_nothing_and_is_lost_to_nobody(start: Start) -> None:
    holder = start('holds_interpreter', 'holder', HELD_S)
    holder.expect('ready')
    talker = start('holds_interpreter', 'talker', HELD_S)
    holder.expect('holds')
    talker.expect(r'answers \[21, 1\]', timeout=100.0)
    talker.expect('lost 0 times')
    talker.succeed()
    holder.expect('heard all in order: True')
    holder.succeed()

"""An extension in C holds the interpreter's lock for seconds: its program is slow meanwhile, and not dead."""

from __future__ import annotations

import pytest
from helpers.isolation import lease_variables
from helpers.programs import Start

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]


@pytest.mark.parametrize(
    ('held_s', 'lease_s'),
    [(6, 20.0), pytest.param(20, 60.0, marks=pytest.mark.long)],
    ids=['a short lease', 'the lease that programs have'],
)
def test_who_holds_the_interpreters_lock_loses_nothing_and_is_lost_to_nobody(
    start: Start, held_s: int, lease_s: float
) -> None:
    """It is held for longer than a link may be silent: a quarter of its lease."""
    lease = lease_variables(lease_s)
    holder = start('holds_interpreter', 'holder', held_s, **lease)
    holder.expect('ready')
    talker = start('holds_interpreter', 'talker', held_s, **lease)
    holder.expect('holds')
    talker.expect(rf'answers \[{held_s + 1}, 1\]', timeout=100.0)
    talker.expect('lost 0 times')
    talker.succeed()
    holder.expect('heard all in order: True')
    holder.write_line('')
    holder.succeed()

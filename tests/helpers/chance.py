"""Random choices of a test that differ in each run, and can be repeated."""

from __future__ import annotations

import os
import random
import sys
from collections.abc import Callable

VARIABLE = 'GOALWIRE_TEST_SEED'


def fresh_chance(record_property: Callable[[str, object], None]) -> random.Random:
    """Return a source of random numbers with a new seed, or with that of GOALWIRE_TEST_SEED.

    The seed is printed, so pytest shows it if the test fails, and it is in the report of `--junitxml`.
    """
    seed = int(os.environ.get(VARIABLE) or random.SystemRandom().randrange(2**32))
    sys.stdout.write(f'{VARIABLE}={seed}\n')
    record_property('seed', seed)
    return random.Random(seed)

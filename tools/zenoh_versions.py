"""Runs what must hold between our Zenoh sessions and eclipse-zenoh's against every release of the latter.

    python tools/zenoh_versions.py [VERSION ...]

Without versions, all that the package index has from 1.5 on. Each is installed into a folder of its own; one
without a wheel for this system is left out. Exits with 1 where a test fails.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parent.parent
TESTS = ROOT / 'tests' / 'transport' / 'zenoh' / 'native'
OLDEST = (1, 5)
FAULTS = {'1.10.0': ('test_peers_meet_through_a_router_and_talk_without_it',)}
"""Tests that a release cannot pass: peers of 1.10.0 never connect to nodes that a router tells of."""


def releases() -> list[str]:
    """Return the releases on the package index, the oldest first."""
    output = _output('-m', 'pip', 'index', 'versions', 'eclipse-zenoh')
    found = re.search(r'Available versions: (.*)', output)
    if found is None:
        sys.exit(f'the package index does not tell which releases there are:\n{output}')
    versions = found.group(1).split(', ')
    return [each for each in reversed(versions) if tuple(map(int, each.split('.')[:2])) >= OLDEST]


def check(version: str) -> str:
    """Return what the tests said with one release: 'passed', 'no wheel', or what failed."""
    with TemporaryDirectory() as folder:
        options = ('--no-deps', '--only-binary=:all:', '--target', folder)
        pip = _run('-m', 'pip', 'install', '-q', *options, f'eclipse-zenoh=={version}')
        if pip.returncode:
            return 'no wheel'
        tests = _run(
            *('-m', 'pytest', '-q', '-p', 'no:cacheprovider', '-k', 'theirs or Theirs'),
            *(str(TESTS / name) for name in ('test_interop.py', 'test_tls.py')),
            *(
                f'--deselect={TESTS.relative_to(ROOT)}/test_interop.py::{name}'
                for name in FAULTS.get(version, ())
            ),
            env=os.environ | {'PYTHONPATH': folder},
        )
    if not tests.returncode:
        return 'passed: ' + tests.stdout.strip().splitlines()[-1]
    failed = [line for line in tests.stdout.splitlines() if line.startswith(('FAILED', 'ERROR'))]
    return '\n    '.join(['FAILED', *(failed or [tests.stdout[-2000:]])])


def _run(*arguments: str, env: dict[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments], cwd=ROOT, env=env, capture_output=True, text=True, check=False
    )


def _output(*arguments: str) -> str:
    done = _run(*arguments)
    return done.stdout + done.stderr


def main() -> int:
    """Check each release; print one line for it."""
    failures = 0
    for version in sys.argv[1:] or releases():
        said = check(version)
        failures += said.startswith('FAILED')
        print(f'{version:8} {said}', flush=True)
    return int(failures > 0)


if __name__ == '__main__':
    sys.exit(main())

"""usage: python tests/fuzz [--seconds 60] [--finds FOLDER] [TARGET…]

Feeds each target with what atheris (libFuzzer) makes of the seeds, each in a process of its own, with 5 s and
1 GiB for one input. Prints how many inputs that were. Exit code 1 where anything was found: the input is in
FOLDER then. Needs `pip install atheris` (Linux and macOS).
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
SECONDS_FOR_ONE = 5
MIB_FOR_ONE = 1024
LONGEST = 4096
GRACE_S = 600
"""The seconds that a process may take beyond its time: it imports, instruments, and ends."""


def fuzz(name: str, seconds: int, finds: Path) -> bool:
    """Fuzz one target; return whether all was well."""
    with tempfile.TemporaryDirectory() as corpus:
        done = subprocess.run(
            [
                sys.executable, str(HERE / 'one.py'), name, corpus, f'-max_total_time={seconds}',
                f'-timeout={SECONDS_FOR_ONE}', f'-rss_limit_mb={MIB_FOR_ONE}', f'-max_len={LONGEST}',
                f'-artifact_prefix={finds}/{name}-', '-print_final_stats=1', '-verbosity=0',
            ],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors='replace', check=False,
            timeout=seconds + GRACE_S,
        )  # fmt: skip
    executed = re.search(r'number_of_executed_units:\s*(\d+)', done.stdout)
    inputs = f'{int(executed.group(1)):,} inputs' if executed else 'no statistics'
    print(f'{name:14} {inputs:>20}  {"a find" if done.returncode else "well"}', flush=True)
    if done.returncode:
        print(done.stdout[-4000:], flush=True)
    return done.returncode == 0


def main() -> None:
    """Take the arguments, and exit with the verdict."""
    sys.path.insert(0, str(HERE.parent))
    from fuzz.targets import TARGETS

    names = [target.name for target in TARGETS]
    parser = argparse.ArgumentParser(prog='python tests/fuzz', description=__doc__)
    parser.add_argument('--seconds', type=int, default=60, help='for each target')
    parser.add_argument('--finds', type=Path, default=Path('fuzz-finds'), metavar='FOLDER')
    parser.add_argument('targets', nargs='*', metavar='TARGET', help=', '.join(names))
    options = parser.parse_args()
    options.finds.mkdir(exist_ok=True)
    well = [fuzz(name, options.seconds, options.finds) for name in options.targets or names]
    sys.exit(not all(well))


if __name__ == '__main__':
    main()

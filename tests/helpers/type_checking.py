"""The remarks of type checkers on a program that uses goalwire as it is installed."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import textwrap
from pathlib import Path

from helpers.environments import ROOT
from helpers.fresh import clean_environment
from helpers.packages import write_files


def type_errors(program: str, folder: Path, *, typings: Path | None = None) -> list[tuple[str, str]]:
    """Return the errors of mypy --strict: line and code of each, none for a well-typed program."""
    write_files(folder, {'program.py': textwrap.dedent(program)})
    environment = clean_environment(**({'MYPYPATH': str(typings)} if typings else {}))
    cache = ROOT / 'build' / 'mypy'  # what one program imports need not be read again for the next
    command = [sys.executable, '-m', 'mypy', '--strict', '--config-file=', 'program.py']
    done = subprocess.run(
        [*command, f'--cache-dir={cache}', '--no-sqlite-cache'],
        cwd=folder, env=environment, capture_output=True, text=True, timeout=50, check=False,
    )  # fmt: skip
    assert done.stderr == ''
    errors = re.findall(r'^program\.py:(\d+): error: .*\[([\w-]+)\]$', done.stdout, re.MULTILINE)
    assert bool(errors) == bool(done.returncode), done.stdout
    return errors


def editor_remarks(program: str, folder: Path) -> list[tuple[int, str]]:
    """Return the remarks of Pyright, which is in many editors: line and rule, none if all is well."""
    settings = {'typeCheckingMode': 'standard', 'pythonVersion': '.'.join(map(str, sys.version_info[:2]))}
    files = {'program.py': textwrap.dedent(program), 'pyrightconfig.json': json.dumps(settings)}
    write_files(folder, files)
    done = subprocess.run(
        [sys.executable, '-m', 'basedpyright', '--outputjson', '--pythonpath', sys.executable, 'program.py'],
        cwd=folder, env=clean_environment(), capture_output=True, text=True, timeout=50, check=False,
    )  # fmt: skip
    found = json.loads(done.stdout)['generalDiagnostics']
    return [(item['range']['start']['line'] + 1, item.get('rule', item['message'])) for item in found]

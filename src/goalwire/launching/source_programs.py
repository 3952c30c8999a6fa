"""Programs of Python packages that are not installed: the console scripts of their setup files.

Each program gets a small starter in the user's cache, which imports the function from the source folder and
calls it, as a script installed by pip does. The folder's name is a hash of the starters' contents, so a
starter is never out of date, and several processes may write it at once.
"""

from __future__ import annotations

import ast
import configparser
import contextlib
import os
import re
import shlex
import sys
import tempfile
import tomllib
from hashlib import sha256
from pathlib import Path

from goalwire.files import cache_folder, read_regular

LARGEST = 2**20
_ENTRY = re.compile(r'\s*([\w.:-]+)\s*=\s*([\w.]+)\s*:\s*([\w.]+)\s*')
_LONGEST_INTERPRETER = 127
"""How many bytes of an interpreter's line every system reads (execve(2)); newer Linux reads 255."""
_STARTER = """\
{interpreter}
# Made by goalwire: {name} of the source folder below.
import sys

sys.path.insert(0, {folder!r})
sys.argv[0] = {name!r}
from {module} import {first}

sys.exit({function}())
"""


def starters(package: str, folder: str) -> list[str]:
    """Return the sorted paths of starters for a source package's programs; [] if it has no programs."""
    texts = {name: _starter(name, target, folder) for name, target in console_scripts(folder).items()}
    if not texts or os.name != 'posix':
        return []
    digest = sha256('\0'.join([folder, *texts.values()]).encode()).hexdigest()[:16]
    try:
        place = Path(cache_folder('sources')) / f'{package}-{digest}'
        place.mkdir(parents=True, exist_ok=True)
        return [_write(place / name, text) for name, text in sorted(texts.items())]
    except OSError:  # the cache cannot be written, or the user has no home
        return []


def console_scripts(folder: str) -> dict[str, tuple[str, str]]:
    """Return (module, function) by program name, from setup.py, setup.cfg and pyproject.toml."""
    return programs_of_group(folder, 'console_scripts')


def programs_of_group(folder: str, group: str) -> dict[str, tuple[str, str]]:
    """Return (module, object) by entry name, for one group of entry points of a source package."""
    found: dict[str, tuple[str, str]] = {}
    for entry in (
        *_of_setup_py(folder, group),
        *_of_setup_cfg(folder, group),
        *_of_pyproject(folder, group),
    ):
        match = _ENTRY.fullmatch(entry)
        if match:
            found[match[1]] = match[2], match[3]
    return found


def _read(folder: str, name: str) -> str:
    with contextlib.suppress(OSError, UnicodeError):
        return read_regular(os.path.join(folder, name), LARGEST).decode()
    return ''


def _of_setup_py(folder: str, group: str) -> list[str]:
    """Return the entry points of a group in setup.py; the file is parsed, not run."""
    with contextlib.suppress(SyntaxError, ValueError, RecursionError):
        for node in ast.walk(ast.parse(_read(folder, 'setup.py'))):
            if not isinstance(node, ast.Dict):
                continue
            for key, value in zip(node.keys, node.values, strict=True):
                is_scripts = isinstance(key, ast.Constant) and key.value == group
                if is_scripts and isinstance(value, ast.List | ast.Tuple):
                    items = [item.value for item in value.elts if isinstance(item, ast.Constant)]
                    return [item for item in items if isinstance(item, str)]
    return []


def _of_setup_cfg(folder: str, group: str) -> list[str]:
    parser = configparser.ConfigParser(interpolation=None)
    with contextlib.suppress(configparser.Error):
        parser.read_string(_read(folder, 'setup.cfg'))
        return parser.get('options.entry_points', group, fallback='').splitlines()
    return []


def _of_pyproject(folder: str, group: str) -> list[str]:
    with contextlib.suppress(tomllib.TOMLDecodeError, AttributeError):
        project = tomllib.loads(_read(folder, 'pyproject.toml')).get('project', {})
        named = project.get('entry-points', {}).get(group, {})
        scripts = project.get('scripts', {}) if group == 'console_scripts' else named
        return [f'{name} = {target}' for name, target in scripts.items()]
    return []


def _starter(name: str, target: tuple[str, str], folder: str) -> str:
    module, function = target
    inner = os.path.join(folder, 'src')
    top = module.partition('.')[0]
    root = inner if os.path.isdir(os.path.join(inner, top)) else folder  # the module may be below src/
    return _STARTER.format(
        interpreter=interpreter_lines(sys.executable),
        name=name,
        folder=root,
        module=module,
        first=function.partition('.')[0],
        function=function,
    )


def interpreter_lines(python: str) -> str:
    """Return the first lines of a program that `python` runs.

    A system takes a path in a first line only up to its first space. Such a path, and a long one, is written
    as in scripts of pip: /bin/sh starts Python, which reads the same lines as a string.
    """
    line = f'#!{python}'
    if ' ' not in python and len(os.fsencode(line)) <= _LONGEST_INTERPRETER:
        return line
    return f"""#!/bin/sh
'''exec' {shlex.quote(python)} "$0" "$@"
' '''"""


def _write(place: Path, text: str) -> str:
    if not place.exists():
        descriptor, temporary = tempfile.mkstemp(dir=place.parent)
        with os.fdopen(descriptor, 'w', encoding='utf-8') as file:
            file.write(text)
        Path(temporary).chmod(0o755)
        Path(temporary).replace(place)  # another process may have been faster: it wrote the same
    return str(place)

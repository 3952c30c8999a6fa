"""Writes what the build makes of the shipped definitions, into src: type stubs and a table of type hashes.

    python tools/generate.py

The build runs it (hatch_build.py), for wheels and editable installs, and mypy does where a definition or a
generator is newer than what was written (`plugins` in pyproject.toml). None of these files is committed. Only
the standard library is needed, and definitions outside this checkout are not looked at.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mypy.plugin import Plugin

SOURCE = Path(__file__).resolve().parents[1] / 'src'
SHARE = SOURCE / 'goalwire' / 'idl' / 'share'
OVERLAY = SOURCE / 'goalwire' / 'overlay'
HASHES = SOURCE / 'goalwire' / 'entities' / 'standard_hashes.py'

SERVED = ('lifecycle_msgs', 'rcl_interfaces', 'type_description_interfaces')
"""Packages whose services every node offers, or every lifecycle node."""
PUBLISHED = (
    'lifecycle_msgs/msg/TransitionEvent',
    'rcl_interfaces/msg/Log',
    'rcl_interfaces/msg/ParameterEvent',
)
_HEADER = '"""Hashes of the types that every node has, written by tools/generate.py; do not edit."""\n'


def generate() -> None:
    """Write everything in a Python of its own, which sees neither installed packages nor workspaces."""
    hidden = {'AMENT_PREFIX_PATH', 'GOALWIRE_INTERFACE_PATH'}
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    command = [sys.executable, '-I', '-S', '-B', __file__, '--here']
    subprocess.run(command, check=True, cwd=Path(__file__).parent, env=environment)


def is_stale() -> bool:
    """Tell whether a file is missing, or older than a definition or a generator."""
    packages = [folder for folder in SHARE.iterdir() if folder.is_dir()]
    made = [HASHES, *(OVERLAY / folder.name / '__init__.pyi' for folder in packages)]
    made += [OVERLAY / kind.relative_to(SHARE) / '__init__.pyi' for kind in SHARE.glob('*/*/')]
    if not all(file.exists() for file in made):
        return True
    generators = [Path(__file__), *(SOURCE / 'goalwire' / 'idl').glob('*.py')]
    used = [*SHARE.rglob('*.*'), *generators, SOURCE / 'goalwire' / 'cdr' / 'type_hash.py']
    return max(file.stat().st_mtime for file in used) > min(file.stat().st_mtime for file in made)


def plugin(_version: str) -> type[Plugin]:
    """Let mypy see the definitions as they are; it asks for this function."""
    from mypy.plugin import Plugin

    if is_stale():
        generate()
    return Plugin


def _write() -> None:
    sys.path.insert(0, str(SOURCE))
    from goalwire.cdr.type_hash import message_facts, service_hashes
    from goalwire.idl.stubs import write_stubs

    write_stubs(OVERLAY, sorted(folder.name for folder in SHARE.iterdir() if folder.is_dir()))
    services = [
        f'{package}/srv/{file.stem}'
        for package in SERVED
        for file in sorted((SHARE / package / 'srv').glob('*.srv'))
    ]
    text = _HEADER + _table('SERVICES', {name: service_hashes(name) for name in services})
    text += '"""Of each service: its hash, and those of its request and its response."""\n'
    text += _table('MESSAGES', {name: message_facts(name) for name in PUBLISHED})
    text += '"""Of each message: its hash, and whether a field of it holds a buffer."""\n'
    HASHES.write_text(text, encoding='utf-8', newline='\n')


def _table(name: str, rows: dict[str, tuple[object, ...]]) -> str:
    lines = [f'    {key!r}: (\n' + ''.join(f'        {part!r},\n' for part in row) + '    ),\n'
             for key, row in rows.items()]  # fmt: skip
    return f'\n{name} = {{\n{"".join(lines)}}}\n'


if __name__ == '__main__':
    _write() if '--here' in sys.argv else generate()

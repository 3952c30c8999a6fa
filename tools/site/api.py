"""The reference of names, from docstrings: goalwire, its test kit, its bags, its errors, and the robot."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from pathlib import Path

from goalwire import errors

KITS = {
    'goalwire': ('goalwire', 'The [asyncio API](../how-to/asyncio-api.md).'),
    'goalwire.testing': ('the test kit', 'How to use it: [tests without a robot](../how-to/testing.md).'),
    'goalwire.bag': ('bags', 'How to use them: [bags](../how-to/bags.md).'),
}
"""The modules that hold public names: what each page is called, and its first sentence."""


def write_api(folder: Path) -> None:
    """Write a page for each module of public names, and one that lists them."""
    folder.mkdir(parents=True, exist_ok=True)
    pages = {}
    for module, (title, intro) in KITS.items():
        pages[module] = _page(module, title, intro, public_names(module))
    pages['goalwire.errors'] = _page(
        'goalwire.errors',
        'errors',
        'When each is raised, and what to do then: [errors](../reference/errors.md).',
        public_names('goalwire.errors'),
    )
    pages['humanoid'] = _robot()
    for name, text in pages.items():
        (folder / f'{name}.md').write_text(text, encoding='utf-8')
    rows = [f'| [{name}]({name}.md) | {text.splitlines()[2]} |' for name, text in pages.items()]
    lines = ['# Names of the library', '', '| module | |', '|---|---|', *rows, '']
    differences = '[differences from rclpy](../reference/differences-from-rclpy.md)'
    lines += ['', f'The names of `rclpy` and its companions are those of ROS 2: {differences}.', '']
    lines += ['```{toctree}', ':hidden:', '', *pages, '```', '']
    (folder / 'index.md').write_text('\n'.join(lines), encoding='utf-8')


def public_names(module: str) -> list[str]:
    """Return the public names of a module, in the order of the alphabet."""
    if module == 'goalwire.errors':
        found = {name: getattr(errors, name) for name in errors.__all__}
        return [name for name, value in found.items() if getattr(value, '__module__', '') == module]
    loaded = importlib.import_module(module)
    names: list[str] = getattr(loaded, '__all__', None) or dir(loaded)
    values = {name: getattr(loaded, name) for name in names if not name.startswith('_')}
    return sorted(
        name
        for name, value in values.items()
        if not inspect.ismodule(value) and getattr(value, '__module__', '').startswith('goalwire')
    )


def _page(module: str, title: str, intro: str, names: list[str]) -> str:
    lines = [f'# {module}: {title}' if title != module else f'# {module}', '', intro, '']
    for name in names:
        lines += _entry(f'{module}.{name}', getattr(importlib.import_module(module), name))
    return '\n'.join(lines)


def _entry(name: str, value: object) -> list[str]:
    """Return the directive for one name."""
    if inspect.isclass(value):
        directive = 'autoexception' if issubclass(value, BaseException) else 'autoclass'
        options = (
            ['   :members:', '   :inherited-members: Exception, object, IntEnum, int, tuple, NamedTuple']
            if directive == 'autoclass'
            else ['   :show-inheritance:', '   :members:']
        )
    elif callable(value):
        directive, options = 'autofunction', []
    else:
        directive, options = 'autodata', []
    return ['```{eval-rst}', f'.. {directive}:: {name}', *options, '```', '']


def _robot() -> str:
    """Return the page of the robot's modules: what each has of its own."""
    import humanoid

    lines = ['# humanoid: the robot', '', 'How it is used: [the humanoid](../how-to/robot.md).', '']
    for found in sorted(pkgutil.walk_packages(humanoid.__path__, 'humanoid.'), key=lambda each: each.name):
        if found.ispkg or found.name.rpartition('.')[2].startswith('_'):
            continue
        lines += [
            f'## {found.name}',
            '',
            '```{eval-rst}',
            f'.. automodule:: {found.name}',
            '   :members:',
            '```',
            '',
        ]
    return '\n'.join(lines)

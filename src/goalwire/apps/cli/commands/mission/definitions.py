"""Finds the missions in a Python file."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.outcome import CommandError, Outcome

if TYPE_CHECKING:
    from goalwire.missions import Definition


def missions_in(file: str) -> dict[str, Definition]:
    """Run a Python file and return its missions by their names. Raises CommandError.

    Imports in the file look into its own folder first, as with `python FILE`.
    """
    from goalwire.missions import Definition

    path = Path(file).resolve()
    if not path.is_file():
        raise CommandError(Outcome.NOT_FOUND, f"there is no file '{file}'")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise CommandError(Outcome.BAD_VALUE, f"'{file}' is not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(path.parent))
    sys.modules[path.stem] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        problem = f"'{file}' cannot be imported: {type(error).__name__}: {error}"
        raise CommandError(Outcome.FAILED, problem) from None
    found = [value for value in vars(module).values() if isinstance(value, Definition)]
    if not found:
        raise CommandError(Outcome.NOT_FOUND, f"'{file}' has no missions: mark one by @mission()")
    return {each.name: each for each in found}

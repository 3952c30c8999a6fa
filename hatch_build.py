"""The build hook: wheels and editable installs hold files that tools/generate.py makes of the definitions.

An sdist has none of these files: it carries the generator, and the wheel built from it runs this hook.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class GenerateHook(BuildHookInterface):  # type: ignore[type-arg]
    """Write the stubs and the table of hashes; `artifacts` in pyproject.toml has the wheel take them."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002 - hatchling's
        subprocess.run([sys.executable, str(Path(self.root, 'tools', 'generate.py'))], check=True)

"""Packages that pip builds in an environment that has goalwire."""

from __future__ import annotations

from pathlib import Path

from helpers.fresh import output_of

PROGRAM = """\
import sys
from pathlib import Path
sys.path[:] = [entry for entry in sys.path if not Path(entry, 'goalwire').is_dir()]
import packaging.version
print(packaging.version.Version('1.0'))
"""


def test_a_build_imports_its_tools_although_goalwires_folder_is_out_of_the_path(tmp_path: Path) -> None:
    """For an isolated build pip takes the environment's folders out of the path, after goalwire.pth ran."""
    assert output_of(PROGRAM, cwd=tmp_path) == '1.0'

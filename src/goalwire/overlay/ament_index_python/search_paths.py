"""ament_index_python.search_paths: the prefixes that are searched, in order."""

from __future__ import annotations

import os
from pathlib import Path

from ament_index_python import _linked_prefixes
from ament_index_python.constants import AMENT_PREFIX_PATH_ENV_VAR, RESOURCE_INDEX_SUBFOLDER

__all__ = ['get_search_paths']


def get_search_paths() -> list[str]:
    """Return the existing folders of AMENT_PREFIX_PATH, then Python's own prefixes.

    pip installs the data files of ament_python packages into Python's prefixes, including share/ament_index,
    which setup.py names. So packages installed by pip are found like packages built by colcon.
    """
    entries = os.environ.get(AMENT_PREFIX_PATH_ENV_VAR, '').split(os.pathsep)
    paths = [entry for entry in entries if entry and Path(entry).is_dir()]
    return paths + [
        prefix
        for prefix in _linked_prefixes.of_pip()
        if prefix not in paths and Path(prefix, RESOURCE_INDEX_SUBFOLDER).is_dir()
    ]

"""Missions are tested in virtual time, in memory."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.missions import Base

from goalwire.testing import Graph, VirtualClock


@pytest.fixture
def base(gw_clock: VirtualClock, gw_graph: Graph, tmp_path: Path) -> Base:
    """A folder with a journal, and a graph in virtual time."""
    return Base(gw_graph, tmp_path)

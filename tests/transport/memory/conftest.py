"""The memory transport alone."""

from __future__ import annotations

import pytest


@pytest.fixture
def transport_name() -> str:
    """Only this one."""
    return 'goalwire_memory'

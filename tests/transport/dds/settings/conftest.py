"""A world in which nothing is set."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from goalwire.rtps.io.settings import Settings
from goalwire.transport.dds.settings import session

VARIABLES = (
    'ROS_AUTOMATIC_DISCOVERY_RANGE',
    'ROS_LOCALHOST_ONLY',
    'ROS_STATIC_PEERS',
    'ROS_DISCOVERY_SERVER',
    'CYCLONEDDS_URI',
    'FASTDDS_DEFAULT_PROFILES_FILE',
    'FASTRTPS_DEFAULT_PROFILES_FILE',
    'NDDS_DISCOVERY_PEERS',
)


@pytest.fixture(autouse=True)
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in VARIABLES:
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def warnings(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The warnings that have been given."""
    told: list[str] = []
    monkeypatch.setattr(session, '_warn', told.append)
    return told


@pytest.fixture
def profile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Settings]:
    """Return the settings that a profile of Fast DDS makes; the text is what stands in its participant."""

    def read(participant: str, transports: str = '', domain: int = 0) -> Settings:
        file = tmp_path / 'profiles.xml'
        file.write_text(
            '<?xml version="1.0"?><dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">'
            f'<profiles><transport_descriptors>{transports}</transport_descriptors>'
            f'<participant profile_name="all" is_default_profile="true"><rtps>{participant}</rtps>'
            '</participant></profiles></dds>'
        )
        monkeypatch.setenv('FASTRTPS_DEFAULT_PROFILES_FILE', str(file))
        return session.session_settings(domain, 'rmw_fastrtps_cpp')

    return read

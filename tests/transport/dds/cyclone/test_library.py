"""The places where libddsc is looked for, and the error if there is none that fits."""

from __future__ import annotations

import ctypes.util
import importlib.util
import platform
import sys
from pathlib import Path

import pytest

from goalwire.errors import TransportError
from goalwire.transport.dds.cyclone import library as libraries
from goalwire.transport.dds.cyclone.abi import Library
from goalwire.transport.dds.cyclone.library import OVERRIDE, find_library


@pytest.fixture
def nowhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine without Cyclone DDS."""
    for name in (OVERRIDE, 'ROS_DISTRO'):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(importlib.util, 'find_spec', lambda name: None)
    monkeypatch.setattr(ctypes.util, 'find_library', lambda name: None)


def test_an_override_is_taken_before_all_others(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    library = tmp_path / 'libddsc.so'
    library.touch()
    monkeypatch.setenv(OVERRIDE, str(library))
    assert find_library() == str(library)


def test_an_override_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(OVERRIDE, '/nowhere/libddsc.so')
    with pytest.raises(
        TransportError, match=r"GOALWIRE_LIBDDSC is '/nowhere/libddsc.so', and there is no such"
    ):
        find_library()


@pytest.mark.usefixtures('nowhere')
def test_without_a_library_it_is_said_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, 'version_info', (3, 13, 0))
    monkeypatch.setattr(platform, 'machine', lambda: 'x86_64')
    with pytest.raises(
        TransportError, match=r"rmw_cyclonedds_cpp needs .* pip install 'cyclonedds==11\.0\.\*'$"
    ):
        find_library()


@pytest.mark.usefixtures('nowhere')
@pytest.mark.skipif(sys.platform != 'linux', reason='elsewhere there are wheels for arm64')
def test_on_arm64_the_systems_own_library_is_pointed_to(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(platform, 'machine', lambda: 'aarch64')
    with pytest.raises(TransportError, match='wheels do not cover Linux on aarch64; install libddsc from'):
        find_library()


@pytest.mark.usefixtures('nowhere')
def test_a_ros_2_beside_is_found_by_its_distribution(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_DISTRO', 'jazzy')
    there = '/opt/ros/jazzy/lib/libddsc.so'
    monkeypatch.setattr(libraries, 'glob', lambda pattern: [there] if pattern == f'{there}*' else [])
    assert find_library() == there


def test_a_library_of_another_kind_is_refused_in_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    other = importlib.util.find_spec('_ctypes')
    if other is None or other.origin is None:
        pytest.skip('this Python has no shared library of its own')
    monkeypatch.setattr(libraries, '_loaded', [])
    monkeypatch.setenv(OVERRIDE, other.origin)
    with pytest.raises(
        TransportError, match=r'cannot be used \(.*dds_create_domain.*\): install the right one'
    ):
        libraries.load()


def test_a_library_whose_messages_come_back_changed_is_refused(
    alone: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    library = Library(find_library())
    assert libraries.find_fault(library) == ''
    monkeypatch.setattr(library, 'ddsi_serdata_size', lambda sample: 4)
    assert libraries.find_fault(library) == 'messages do not come back as they were sent'

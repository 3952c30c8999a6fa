"""The generated codec and the hashes against a real ROS 2 (tests/data/vectors)."""

from __future__ import annotations

import pytest
from helpers.vectors import WORKSPACE, Case, build, cdr_cases, type_hashes

from goalwire.cdr import codec
from goalwire.idl import get_interface, type_hash


@pytest.fixture(autouse=True)
def workspace(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('GOALWIRE_INTERFACE_PATH', str(WORKSPACE))


PACKAGES = sorted({name.partition('/')[0] for name in type_hashes()})


def cases_of(package: str) -> list[Case]:
    return [case for name, cases in cdr_cases().items() if name.startswith(f'{package}/') for case in cases]


@pytest.mark.parametrize('package', PACKAGES)
def test_bytes_match_ros2(package: str) -> None:
    for case in cases_of(package):
        message = build(get_interface(case.type_name), case.value)
        written = codec.encode(message)
        assert written == case.cdr[: len(written)], case.type_name
        assert len(case.cdr) - len(written) < 4, case.type_name


@pytest.mark.parametrize('package', PACKAGES)
def test_bytes_of_ros2_are_understood(package: str) -> None:
    for case in cases_of(package):
        cls = get_interface(case.type_name)
        expected = repr(build(cls, case.value))  # repr, since nan is unequal to itself
        assert repr(codec.decode(case.cdr, cls)) == expected
        assert repr(codec.decode(memoryview(case.cdr), cls)) == expected


@pytest.mark.parametrize('package', PACKAGES)
def test_a_new_message_holds_the_defaults_of_ros2(package: str) -> None:
    for case in cases_of(package):
        if case.defaults:
            written = codec.encode(get_interface(case.type_name)())
            assert written == case.cdr[: len(written)], case.type_name


@pytest.mark.parametrize('package', PACKAGES)
def test_hashes_match_ros2(package: str) -> None:
    expected = {name: value for name, value in type_hashes().items() if name.startswith(f'{package}/')}
    assert {name: type_hash(name) for name in expected} == expected


def test_every_vector_is_used() -> None:
    assert sum(len(cases_of(package)) for package in PACKAGES) == 1170
    assert len(type_hashes()) == 473

from __future__ import annotations

import pytest
from rclpy.type_hash import TypeHash

DIGITS = bytes(range(32)).hex()


def test_a_hash_is_written_as_rihs() -> None:
    assert str(TypeHash(1, bytes(range(32)))) == f'RIHS01_{DIGITS}'


@pytest.mark.parametrize('unknown', [TypeHash(), TypeHash(0, bytes(32)), TypeHash(1, b'x')])
def test_an_unknown_hash_says_so(unknown: TypeHash) -> None:
    assert str(unknown) == 'INVALID'


def test_a_hash_is_read_from_its_text() -> None:
    assert TypeHash.from_text(f'RIHS01_{DIGITS}') == TypeHash(1, bytes(range(32)))


@pytest.mark.parametrize('text', ['', 'RIHS01_', 'RIHS01_zz', 'RIHS01_00', 'MD5_00'])
def test_a_text_that_is_no_hash_gives_an_unknown_one(text: str) -> None:
    assert TypeHash.from_text(text) == TypeHash()


def test_hashes_are_equal_by_value_and_not_hashable() -> None:
    assert TypeHash(1, bytes(32)) != TypeHash(2, bytes(32))
    assert TypeHash() != 1
    with pytest.raises(TypeError, match="unhashable type: 'TypeHash'"):
        hash(TypeHash())


@pytest.mark.parametrize('arguments', [('a', bytes(32)), (1, 'x'), (1, bytearray(32))])
def test_a_part_of_another_type_is_refused(arguments: tuple[object, object]) -> None:
    with pytest.raises(AssertionError, match='must be'):
        TypeHash(*arguments)  # type: ignore[arg-type]

"""rclpy.type_hash: the hash that tells two versions of one type apart."""

from __future__ import annotations

from typing import Self

_TYPE_HASH_SIZE = 32
_UNSET_VERSION = -1


class TypeHash:
    """The SHA-256 of a type's description.

    Version 1 is RIHS01; a lower version means that the hash is unknown.
    """

    __slots__ = ['_value', '_version']

    def __init__(self, version: int = _UNSET_VERSION, value: bytes = bytes(_TYPE_HASH_SIZE)) -> None:
        self.version = version
        self.value = value

    @classmethod
    def from_text(cls, text: str) -> Self:
        """Return the hash in a text 'RIHS01_<64 hex digits>'; for any other text an unknown hash."""
        prefix, _, digits = text.partition('_')
        try:
            version, value = int(prefix.removeprefix('RIHS')), bytes.fromhex(digits)
        except ValueError:
            return cls()
        return cls(version, value) if len(value) == _TYPE_HASH_SIZE else cls()

    @property
    def version(self) -> int:
        """The version of the rules by which the hash was made."""
        return self._version

    @version.setter
    def version(self, value: int) -> None:
        if not isinstance(value, int):
            raise AssertionError(f'version must be an int, got {value!r}')  # noqa: TRY004 - rclpy's own type
        self._version = value

    @property
    def value(self) -> bytes:
        """The 32 bytes of the hash."""
        return self._value

    @value.setter
    def value(self, value: bytes) -> None:
        if not isinstance(value, bytes):
            raise AssertionError(f'value must be bytes, got {value!r}')  # noqa: TRY004 - rclpy's own type
        self._value = value

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TypeHash):
            return False
        return (self._version, self._value) == (other._version, other._value)

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        if self._version <= 0 or len(self._value) != _TYPE_HASH_SIZE:
            return 'INVALID'
        return f'RIHS{self._version:02}_{self._value.hex()}'

"""The mesh files that the page may load: those that a robot's URDF names, below share folders of packages.

COLLADA is turned into glTF here, since the page's 3D library reads that. Other files are sent as they are.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from hashlib import sha256
from pathlib import Path
from typing import TypeAlias
from urllib.parse import unquote

from goalwire.errors import RemoteError

MOST_BYTES = 64 << 20
MOST_COLLADA_BYTES = 32 << 20
MOST_PICTURE_BYTES = 16 << 20
MOST_KEPT_BYTES = 64 << 20
"""The most bytes of files that are kept after they were turned into glTF."""
SUFFIXES = frozenset({'.stl', '.obj', '.glb', '.gltf', '.dae'})
PICTURE_SUFFIXES = frozenset({'.png', '.jpg', '.jpeg'})

_Stamp: TypeAlias = tuple[int, int]


def mesh_file(name: str) -> Path:
    """Return the file of a mesh that is named package://PACKAGE/…; raises RemoteError for all else."""
    return _share_and_file(name)[1]


def _share_and_file(name: str) -> tuple[Path, Path]:
    from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

    prefix = 'package://'
    if not name.startswith(prefix):
        raise RemoteError(f'meshes are taken from package://…, not from {name[:80]!r}')
    package, _, inner = unquote(name.removeprefix(prefix)).partition('/')
    try:
        share = Path(get_package_share_directory(package)).resolve()
    except (PackageNotFoundError, ValueError):
        raise RemoteError(f"the package '{package[:80]}' is not installed here") from None
    file = _inside(share, share, inner)
    if file is None or file.suffix.lower() not in SUFFIXES:
        ends = ', '.join(sorted(SUFFIXES))
        raise RemoteError(f'{name[:80]!r} is not a mesh file of its package; meshes end in {ends}')
    most = MOST_COLLADA_BYTES if file.suffix.lower() == '.dae' else MOST_BYTES
    if not _is_file(file, most):
        raise RemoteError(f'{name[:80]!r} is not there, or too large')
    return share, file


def _inside(share: Path, folder: Path, name: str) -> Path | None:
    """Return the file of a name that is relative to a folder; None if it lies outside the share folder."""
    try:
        file = (folder / name).resolve()
    except (OSError, ValueError):  # a circle of links, or a NUL in the name
        return None
    return file if file.is_relative_to(share) else None


def _is_file(file: Path, most_bytes: int) -> bool:
    try:
        return file.is_file() and file.stat().st_size <= most_bytes
    except OSError:  # a name that is too long, or a file that has just gone
        return False


class Meshes:
    """The mesh files that descriptions name, by keys. Only these files, and their pictures, are served."""

    def __init__(self) -> None:
        self._files: dict[str, Path] = {}
        self._shares: dict[str, Path] = {}
        """By key: the share folder of a mesh's package, in which its pictures are."""
        self._refusals = self._seen_refusals = 0
        self._problems: dict[Path, tuple[_Stamp, str]] = {}
        self._kept: OrderedDict[str, tuple[_Stamp, bytes]] = OrderedDict()
        """By key: the latest files that were turned into glTF; the one that was used last stands last."""
        self._turn = asyncio.Lock()

    @property
    def version(self) -> int:
        """A number that changes if files could not be read: pages then draw their robots without them.

        It stays as long as files are being read, so that a page with many such files is drawn again once.
        """
        if not self._turn.locked():
            self._seen_refusals = self._refusals
        return self._seen_refusals

    def url(self, name: str) -> str:
        """Return the address of a mesh; raises RemoteError if it may not, or cannot, be served."""
        share, file = _share_and_file(name)
        stamp, problem = self._problems.get(file, (None, ''))
        if stamp is not None and stamp == _stamp(file):
            raise RemoteError(f'{name[:80]!r} cannot be shown: {problem}')
        key = self._keep(file)
        self._shares[key] = share
        return f'/console/mesh/{key}'

    def file(self, key: str) -> Path | None:
        """Return the file, a mesh or a picture, that a key stands for."""
        return self._files.get(key)

    async def as_gltf(self, key: str) -> bytes:
        """Return the COLLADA file that a key stands for, as glTF. Raises RemoteError if it cannot be read.

        One file is turned at a time, in a thread: large ones take seconds and much memory.
        """
        file = self._files[key]
        async with self._turn:
            stamp = _stamp(file)
            kept = self._kept.pop(key, None)
            if kept is None or kept[0] != stamp:
                try:
                    kept = (stamp, await asyncio.to_thread(self._turned, file, self._shares[key]))
                except (ValueError, OSError) as error:
                    self._problems[file] = (stamp, str(error))
                    self._refusals += 1
                    raise RemoteError(f'{file.name} cannot be shown: {error}') from None
            self._kept[key] = kept
            while sum(len(data) for _, data in self._kept.values()) > MOST_KEPT_BYTES:
                self._kept.popitem(last=False)
            return kept[1]

    def _turned(self, file: Path, share: Path) -> bytes:
        from goalwire.apps.console.state.collada.gltf import write_gltf
        from goalwire.apps.console.state.collada.reader import read_collada

        def picture_url(name: str) -> str:  # relative to the mesh's own address
            picture = _inside(share, file.parent, unquote(name).replace('\\', '/'))
            if picture is None or picture.suffix.lower() not in PICTURE_SUFFIXES:
                return ''
            return self._keep(picture) if _is_file(picture, MOST_PICTURE_BYTES) else ''

        with file.open('rb') as source:
            data = source.read(MOST_COLLADA_BYTES + 1)
        if len(data) > MOST_COLLADA_BYTES:
            raise ValueError(f'it has more than {MOST_COLLADA_BYTES >> 20} MB')
        return write_gltf(read_collada(data, picture_url))

    def _keep(self, file: Path) -> str:
        """Return the key of a file, under which it is served from now on."""
        key = sha256(str(file).encode()).hexdigest()[:24] + file.suffix.lower()
        self._files[key] = file
        return key


def _stamp(file: Path) -> _Stamp:
    """Return what changes if a file changes: its time of change, in ns, and size; zeros if it has gone."""
    try:
        found = file.stat()
    except OSError:
        return (0, 0)
    return (found.st_mtime_ns, found.st_size)

"""Which mesh files are served, and COLLADA on its way to the page."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest
from helpers.meshes import collada_box, share_folder

from goalwire.apps.console.state import meshes
from goalwire.apps.console.state.meshes import Meshes, mesh_file
from goalwire.errors import RemoteError


@pytest.fixture
def share(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The share folder of an installed package, `arm`."""
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    return share_folder(tmp_path, 'arm')


def test_meshes_are_files_of_packages_alone(share: Path) -> None:
    (share / 'meshes').mkdir()
    (share / 'meshes' / 'hand.stl').write_bytes(b'solid')
    (share / 'meshes' / 'hand.OBJ').write_bytes(b'v 0 0 0')
    (share / 'secret.txt').write_bytes(b'secret')
    (share.parent / 'outside.stl').write_bytes(b'solid')
    (share / 'link.stl').symlink_to(share.parent / 'outside.stl')
    assert mesh_file('package://arm/meshes/hand.stl').name == 'hand.stl'
    assert mesh_file('package://arm/meshes/hand.OBJ').name == 'hand.OBJ'
    for name in (
        'file:///etc/passwd',
        '/etc/passwd',
        'http://elsewhere/x.stl',
        'package://arm/secret.txt',
        'package://arm/../outside.stl',
        'package://arm/%2e%2e/outside.stl',
        'package://arm//etc/passwd',
        'package://arm/link.stl',
        'package://arm/meshes/none.stl',
        'package://arm/meshes/%00.stl',
        f'package://arm/{"long" * 100}.stl',
        'package://../x.stl',
        'package://nobody/x.stl',
    ):
        with pytest.raises(RemoteError):
            mesh_file(name)


def test_collada_is_sent_as_gltf_and_turned_once(share: Path) -> None:
    (share / 'arm.dae').write_text(collada_box(1, 2, 3), encoding='utf-8')

    async def turn() -> None:
        served = Meshes()
        key = served.url('package://arm/arm.dae').rsplit('/', 1)[1]
        first = await served.as_gltf(key)
        assert first.startswith(b'glTF')
        assert await served.as_gltf(key) is first
        (share / 'arm.dae').write_text(collada_box(1, 2, 3.5), encoding='utf-8')
        assert await served.as_gltf(key) != first, 'the file has changed'

    asyncio.run(turn())


def test_a_picture_of_a_mesh_is_served_if_it_lies_in_the_package(share: Path) -> None:
    (share / 'skin one.png').write_bytes(b'\x89PNG')
    (share / 'notes.txt').write_bytes(b'secret')
    (share.parent / 'outside.png').write_bytes(b'\x89PNG')
    (share / 'meshes').mkdir()

    async def pictures_of(name: str) -> list[Path]:
        (share / 'meshes' / 'arm.dae').write_text(collada_box(1, 1, 1, picture=name), encoding='utf-8')
        served = Meshes()
        key = served.url('package://arm/meshes/arm.dae').rsplit('/', 1)[1]
        data = await served.as_gltf(key)
        found = [served.file(each) for each in served._files if each.encode() in data]
        return [each for each in found if each is not None]

    for name in ('../skin%20one.png', '..\\skin one.png'):
        assert asyncio.run(pictures_of(name)) == [share / 'skin one.png']
    for name in ('../notes.txt', '../../outside.png', 'none.png', '%00.png', 'file:///etc/passwd'):
        assert asyncio.run(pictures_of(name)) == []


def test_a_file_that_cannot_be_read_is_told_until_it_changes(share: Path) -> None:
    file = share / 'arm.dae'
    file.write_text('<COLLADA>', encoding='utf-8')

    async def turn() -> None:
        served = Meshes()
        before = served.version
        key = served.url('package://arm/arm.dae').rsplit('/', 1)[1]
        with pytest.raises(RemoteError, match=r'arm\.dae cannot be shown: it cannot be read as XML'):
            await served.as_gltf(key)
        assert served.version != before, 'pages draw their robots again'
        with pytest.raises(RemoteError, match='cannot be read as XML'):
            served.url('package://arm/arm.dae')
        file.write_text(collada_box(1, 1, 1), encoding='utf-8')
        assert served.url('package://arm/arm.dae')
        assert await served.as_gltf(key)

    asyncio.run(turn())


def test_a_file_that_has_gone_or_has_grown_is_told(share: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = share / 'arm.dae'
    file.write_text(collada_box(1, 1, 1), encoding='utf-8')
    served = Meshes()
    key = served.url('package://arm/arm.dae').rsplit('/', 1)[1]
    monkeypatch.setattr(meshes, 'MOST_COLLADA_BYTES', 100)
    with pytest.raises(RemoteError, match='it has more than'):
        asyncio.run(served.as_gltf(key))
    with pytest.raises(RemoteError, match='too large'):
        served.url('package://arm/arm.dae')
    file.unlink()
    with pytest.raises(RemoteError, match='No such file'):
        asyncio.run(served.as_gltf(key))


def test_the_files_that_are_kept_are_limited(share: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ('a', 'b', 'c'):
        (share / f'{name}.dae').write_text(collada_box(1, 1, 1), encoding='utf-8')

    async def turn() -> None:
        served = Meshes()
        keys = [served.url(f'package://arm/{name}.dae').rsplit('/', 1)[1] for name in 'abc']
        size = len(await served.as_gltf(keys[0]))
        monkeypatch.setattr(meshes, 'MOST_KEPT_BYTES', 2 * size)
        for key in (keys[1], keys[0], keys[2]):
            await served.as_gltf(key)
        assert list(served._kept) == [keys[0], keys[2]]

    asyncio.run(turn())

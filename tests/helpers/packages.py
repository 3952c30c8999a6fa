"""Interface packages written by a test."""

from __future__ import annotations

from pathlib import Path


def write_package(folder: Path, name: str, files: dict[str, str], *, manifest: str | None = None) -> Path:
    """Write <folder>/package.xml for `name` (or the given text) and the files {'msg/Foo.msg': text}."""
    folder.mkdir(parents=True, exist_ok=True)
    text = f'<package format="3"><name>{name}</name></package>' if manifest is None else manifest
    (folder / 'package.xml').write_text(text, encoding='utf-8')
    write_files(folder, files)
    return folder


def write_files(folder: Path, files: dict[str, str]) -> Path:
    """Write text files below a folder."""
    for name, text in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding='utf-8')
    return folder

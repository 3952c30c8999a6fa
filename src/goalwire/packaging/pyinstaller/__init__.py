"""Tells PyInstaller what a program with goalwire needs; the entry point `pyinstaller40` leads here."""

from pathlib import Path


def hook_folders() -> list[str]:
    """Return the folder with the hooks."""
    return [str(Path(__file__).parent)]

"""Hooks for tools that pack programs, such as PyInstaller."""

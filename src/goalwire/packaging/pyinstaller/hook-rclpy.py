"""PyInstaller's hook: rclpy imports its modules when a program first names them."""

from PyInstaller.utils.hooks import collect_submodules

hiddenimports = ['goalwire.idl.hook', *collect_submodules('rclpy')]

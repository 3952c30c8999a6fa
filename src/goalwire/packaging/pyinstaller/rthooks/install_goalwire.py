"""Runs first in a frozen program, which reads no .pth: makes interfaces importable."""

import goalwire.idl.hook

goalwire.idl.hook.install()

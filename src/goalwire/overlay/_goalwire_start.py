"""Run by goalwire.pth at every start of Python in this environment: so it is small, and imports nothing.

It puts a finder before the place of the import hook (goalwire.idl.hook). An import that may concern the
hook loads that. A program that imports Python's own library alone never does, which saves it a millisecond.
"""

import sys

_NOT_OURS = sys.stdlib_module_names | {
    'goalwire',  # the hook itself
    'sitecustomize',  # these three are imported, and mostly missed, at each start of some Pythons
    'usercustomize',
    'apport_python_hook',
}


class HookLoader:
    """A meta path finder that finds nothing, but has the hook installed behind it."""

    finds_interfaces = True  # as goalwire.idl.hook.InterfaceFinder

    def __init__(self) -> None:
        self._is_done = False

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> None:
        """Load the hook, which importlib asks next, unless the module is one of Python's own library."""
        if self._is_done or fullname.partition('.')[0] in _NOT_OURS:
            return
        from goalwire.idl import hook

        hook.install()
        self._is_done = True


def install() -> None:
    """Put the finder before Python's path finder."""
    names = [getattr(finder, '__name__', '') for finder in sys.meta_path]
    place = names.index('PathFinder') if 'PathFinder' in names else len(names)
    sys.meta_path.insert(place, HookLoader())


install()

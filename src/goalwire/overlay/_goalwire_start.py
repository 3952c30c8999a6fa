"""goalwire.pth runs this module at every start of Python in this environment, so the module is small.

It installs a finder that loads the import hook (goalwire.idl.hook) at the first import outside the standard
library. A program that imports only the standard library never loads the hook, which saves a millisecond.
"""

import sys

_NOT_OURS = sys.stdlib_module_names | {
    'goalwire',  # the hook itself
    'sitecustomize',  # some Python builds try to import this and the next two at each start
    'usercustomize',
    'apport_python_hook',
}


class HookLoader:
    """A meta path finder that finds no module: it installs the import hook, which finds them, when needed."""

    finds_interfaces = True  # goalwire.idl.hook.InterfaceFinder has this attribute, too

    def __init__(self) -> None:
        self._is_done = False

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> None:
        """Install the import hook, which importlib asks next, unless the standard library has the module."""
        if self._is_done or fullname.partition('.')[0] in _NOT_OURS:
            return
        try:
            from goalwire.idl import hook
        except ModuleNotFoundError as error:
            if error.name != 'goalwire':
                raise
            return  # pip builds a package: it has taken this environment's folders out of the path

        hook.install()
        self._is_done = True


def install() -> None:
    """Put a HookLoader before Python's path finder."""
    names = [getattr(finder, '__name__', '') for finder in sys.meta_path]
    place = names.index('PathFinder') if 'PathFinder' in names else len(names)
    sys.meta_path.insert(place, HookLoader())


install()

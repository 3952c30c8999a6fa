"""Runs code that is generated at run time, such that tracebacks show its lines.

For a traceback, `linecache` asks a module's loader for the source. So `linecache`, which imports `tokenize`,
need not be imported before a traceback is printed.
"""

from __future__ import annotations


class _SourceLoader:
    """Returns the source of one piece of generated code, as a module's loader does (PEP 302)."""

    def __init__(self, source: str) -> None:
        self._source = source

    def get_source(self, _name: str) -> str:
        """Return the source."""
        return self._source


def run_source(source: str, names: dict[str, object], title: str) -> None:
    """Run the source with the global names `names`; tracebacks show `title` in place of a file's name."""
    # The name ends with .py: linecache does not ask for the lines of a file whose name ends with '>'.
    filename = f'<goalwire {title}>.py'
    names.setdefault('__name__', 'goalwire_generated')
    names['__loader__'] = _SourceLoader(source)
    exec(compile(source, filename, 'exec'), names)  # noqa: S102 - made from checked names

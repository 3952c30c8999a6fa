"""Code that is generated at run time: run, with its lines shown in tracebacks.

For a traceback `linecache` asks a module's loader for the source. So `linecache`, which imports
`tokenize`, is not imported unless a traceback is printed.
"""

from __future__ import annotations


class _SourceLoader:
    """Has the source of one piece of generated code, as a module's loader does (PEP 302)."""

    def __init__(self, source: str) -> None:
        self._source = source

    def get_source(self, _name: str) -> str:
        """Return the source."""
        return self._source


def run_source(source: str, names: dict[str, object], title: str) -> None:
    """Run the source in `names`; `title` is what tracebacks show in place of a file."""
    # linecache does not ask for the lines of a file whose name ends with '>'.
    filename = f'<goalwire {title}>.py'
    names.setdefault('__name__', 'goalwire_generated')
    names['__loader__'] = _SourceLoader(source)
    exec(compile(source, filename, 'exec'), names)  # noqa: S102 - made from checked names

"""Fuzzes one target in this process: one.py TARGET CORPUS [libFuzzer's options]."""

from __future__ import annotations

import sys
from pathlib import Path

import atheris

sys.path.insert(0, str(Path(__file__).parents[1]))


def main() -> None:
    """Write the seeds into the corpus, instrument goalwire, and go on until the time is over."""
    name, corpus, *options = sys.argv[1:]
    with atheris.instrument_imports(include=['goalwire'], enable_loader_override=False):
        from fuzz.targets import TARGETS

    target = next(target for target in TARGETS if target.name == name)
    for number, seed in enumerate(target.seeds):
        (Path(corpus) / f'seed{number}').write_bytes(seed)
        target(seed)  # makes the codecs, which are then instrumented, too
    instrument_codecs()

    def read(data: bytes) -> None:
        target(data)

    atheris.Setup([sys.argv[0], corpus, *options], read)
    atheris.Fuzz()


def instrument_codecs() -> None:
    """The code of codecs is generated: no import brings it."""
    import gc
    from types import FunctionType

    for function in gc.get_objects():
        if isinstance(function, FunctionType) and function.__code__.co_filename.startswith('<goalwire '):
            atheris.instrument_func(function)


if __name__ == '__main__':
    main()

"""Builds the site without the internet: python -m tools.site [folder], build/site without."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

from sphinx.cmd.build import build_main

from tools.site.api import write_api
from tools.site.commands import write_commands
from tools.site.pages import ROOT, Pages, descriptions

HERE = Path(__file__).resolve().parent


def build(folder: Path) -> int:
    """Build the site into `folder`/html; every warning is an error. Returns Sphinx's exit code."""
    pages = folder / 'pages'
    shutil.rmtree(folder, ignore_errors=True)
    pages.mkdir(parents=True)
    Pages(pages).write()
    write_commands(pages / 'commands')
    write_api(pages / 'api')
    known = f'const DESCRIPTIONS = {json.dumps(descriptions(), indent=0)};\n'
    scorer = folder / 'scorer.js'
    scorer.write_text(known + (HERE / 'scorer.js').read_text(encoding='utf-8'), encoding='utf-8')
    settings = ['-c', str(HERE), '-D', f'html_search_scorer={scorer}']
    return build_main(['-q', '-b', 'html', '--keep-going', '-W', *settings, str(pages), str(folder / 'html')])


if __name__ == '__main__':
    sys.exit(build(Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else ROOT / 'build' / 'site'))

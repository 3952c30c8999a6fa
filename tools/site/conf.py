"""Sphinx's settings for the site; `python -m tools.site` makes the pages that it reads."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from sphinx.pycode import ModuleAnalyzer
from sphinx.search.en import SearchEnglish

import goalwire
from goalwire import errors
from tools.site.api import public_names

project = 'goalwire'
author = 'goalwire developers'
version = release = goalwire.__version__
extensions = ['myst_parser', 'sphinx.ext.autodoc']

html_theme = 'furo'
html_title = f'goalwire {release}'
html_copy_source = False
html_show_sphinx = False
html_static_path = ['_static']
html_css_files = ['site.css']

myst_heading_anchors = 6
myst_links_external_new_tab = True
suppress_warnings = ['misc.highlighting_failure']  # output of a terminal that looks like no language
default_role = 'py:obj'

autodoc_member_order = 'bysource'
autodoc_typehints_format = 'short'
autodoc_preserve_defaults = True

# People ask questions: these words say nothing about the page that answers.
_SAY_NOTHING = """
about all am an any anyone before between can cannot do does doing from get gets give given has have
how i its let long make makes many me much my need one other over say says see should so some
somebody take tell than them us use used using want wants we what when where which while who whose
why without work works would you your
"""
SearchEnglish.stopwords = SearchEnglish.stopwords | set(_SAY_NOTHING.split())

ERRORS = {name for name in public_names('goalwire.errors') if name[0].isupper()}
_NAME = re.compile(r'(?<![`\w.])(?:goalwire\.)?([A-Z]\w+)(?![`\w])')


def link_errors(_app: Any, _what: str, _name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """Make links of the errors that a docstring names."""
    for index, line in enumerate(lines):
        lines[index] = _NAME.sub(
            lambda found: f':py:exc:`~goalwire.errors.{found[1]}`' if found[1] in ERRORS else found[0], line
        )


def read_errors() -> None:
    """Have autodoc find the attributes of errors, which name the package as their module, in its files."""
    files = sorted(Path(errors.__file__).parent.glob('*.py'))
    source = '\n'.join(file.read_text(encoding='utf-8') for file in files)
    ModuleAnalyzer.cache['module', errors.__name__] = ModuleAnalyzer.for_string(source, errors.__name__)


def setup(app: Any) -> None:
    """Sphinx calls this."""
    read_errors()
    app.connect('autodoc-process-docstring', link_errors)

"""The command line: `goalwire` and `ros2` are one program. See docs/reference/command-line.md.

`main` imports only the module of the given noun, so that `--help` and `list` start fast. That module, in
`commands`, defines `NOUN` with its verbs (`framework/verbs.py`); `framework/nouns.py` lists all nouns.
"""

"""The command line: `goalwire` and `ros2` are one program. See docs/reference/command-line.md.

`main` looks up the noun and imports its module alone, so that `--help` and `list` start fast. A noun's
module, in `commands`, offers one `NOUN`, made of verbs (`framework/verbs.py`), and is named in the table of
`framework/nouns.py`.
"""

"""The command line: `goalwire` and `ros2` are one program. See docs/reference/command-line.md.

`main` looks up the noun and imports its module alone, so that `--help` and `list` start fast. A noun's
module offers one `NOUN`, made of verbs (`verbs.py`), and is named in the table of `nouns.py`.
"""

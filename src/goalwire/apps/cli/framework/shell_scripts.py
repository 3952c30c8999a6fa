"""The completion scripts of shells, how shells pass their line, and how words are quoted.

Names come from strangers: any peer may announce a topic called ``/camera`>file` ``, and a shell runs the
contents of its line. So a candidate is quoted as one literal word, or left out.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Sequence

from goalwire.patterns import Pattern

# Each script calls `ros2 _complete SHELL WORD …`, the unfinished word last; bash's passes its whole line.
SCRIPTS = {
    'bash': """_goalwire_complete() {
    local each
    COMPREPLY=()
    while IFS= read -r each; do
        if [[ -n $each ]]; then COMPREPLY+=("$each"); fi
    done < <("${COMP_WORDS[0]}" _complete bash "${COMP_LINE:0:COMP_POINT}" 2>/dev/null)
    if [[ ${COMPREPLY[0]-} == *[=.] ]]; then compopt -o nospace 2>/dev/null; fi
}
complete -o default -F _goalwire_complete ros2 goalwire
""",
    'zsh': """_goalwire_complete() {
    local -a said found open whole
    said=("${(@Q)words[2,CURRENT-1]}")
    found=("${(@f)$("${words[1]}" _complete zsh "${said[@]}" "${words[CURRENT]}" 2>/dev/null)}")
    open=(${(M)found:#*[=.]})
    whole=(${found:#*[=.]})
    (( ${#open} )) && compadd -U -Q -S '' -- "${open[@]}"
    (( ${#whole} )) && compadd -U -Q -- "${whole[@]}"
    (( ${#open} + ${#whole} )) || _files
}
(( $+functions[compdef] )) || { autoload -Uz compinit && compinit; }
compdef _goalwire_complete ros2 goalwire
""",
    'fish': """for program in ros2 goalwire
    complete -c $program -f -a \\
        "(set -l said (commandline -opc); $program _complete fish \\$said[2..] (commandline -ct) 2>/dev/null)"
end
""",
}

_PLAIN = Pattern(r'[A-Za-z0-9_./@%+,:-][A-Za-z0-9_./@%+,:=-]*')
_QUOTING = set('\'"\\`$')


def words_of(shell: str, arguments: Sequence[str]) -> list[str] | None:
    """Return the words of the line, the unfinished one last; None if the line cannot be split safely.

    bash splits at '=' and ':', too, so its script gives the whole line.
    """
    if shell != 'bash':
        words = list(arguments) or ['']
        return None if _QUOTING & set(words[-1]) else words
    line = arguments[0] if arguments else ''
    begun = '' if not line or line[-1].isspace() else line.split()[-1]
    if _QUOTING & set(begun):
        return None
    try:
        said = shlex.split(line[: len(line) - len(begun)])
    except ValueError:
        return None  # The line has an open quotation mark.
    return [*said[1:], begun]


def quote_words(shell: str, candidates: Iterable[str]) -> Iterator[str]:
    """Yield the candidates, each quoted as one word of the shell; leave out those that cannot be quoted.

    fish quotes by itself. A control character would split a candidate in two, or control the terminal.
    """
    for each in candidates:
        if not each.isprintable() or not each:
            continue
        yield each if shell == 'fish' or is_plain(each) else shlex.quote(each)


def is_plain(word: str) -> bool:
    """Return True if a word needs no quotes in any shell."""
    return _PLAIN.fullmatch(word) is not None

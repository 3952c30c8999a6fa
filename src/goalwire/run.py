"""Run a program on goalwire where a real ROS 2 is installed too: python -m goalwire.run prog.py [ARGS…].

    python -m goalwire.run prog.py --ros-args -r __node:=other
    python -m goalwire.run -m package.module ARGS

goalwire's rclpy and its companions then come before real ones, in this process and in those it starts.
Interface packages that are importable stay as they are: goalwire takes real rosidl classes too.
"""

import os
import runpy
import sys

from goalwire.idl import hook

USAGE = 'usage: python -m goalwire.run (PROGRAM | -m MODULE) [ARGUMENT …]'


def main(arguments: list[str]) -> int:
    """Run the program in this process; returns 2 for a wrong command line."""
    if not arguments or arguments[0] in ('-h', '--help') or arguments == ['-m']:
        print(USAGE, file=sys.stderr)
        return 0 if arguments[:1] in (['-h'], ['--help']) else 2
    os.environ[hook.OVERLAY_FIRST] = '1'  # a variable, and not an argument: child processes inherit it
    hook.install()
    if arguments[0] == '-m':
        sys.argv = arguments[1:]
        runpy.run_module(arguments[1], run_name='__main__', alter_sys=True)
        return 0
    program = arguments[0]
    if not os.path.exists(program):
        print(f'goalwire.run: no such file: {program}', file=sys.stderr)
        return 2
    sys.argv = arguments
    if not sys.flags.safe_path and sys.path:
        sys.path[0] = os.path.dirname(os.path.abspath(program))  # as in `python PROGRAM`
    runpy.run_path(
        os.path.abspath(program), run_name='__main__'
    )  # __file__ is absolute, as with `python PROGRAM`
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))

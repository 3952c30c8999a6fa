"""python -m goalwire.cli: the program `goalwire`."""

import sys

from goalwire.cli.main import main

if __name__ == '__main__':
    sys.exit(main())

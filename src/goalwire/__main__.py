"""Makes `python -m goalwire` run the program `goalwire`."""

import sys

from goalwire.apps.cli.main import main

if __name__ == '__main__':
    sys.exit(main())

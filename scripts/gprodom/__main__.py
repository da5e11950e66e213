"""``python -m gprodom``."""

import sys

from gprodom.cli import main

if __name__ == "__main__":
    sys.exit(main())

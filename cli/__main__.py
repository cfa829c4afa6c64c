"""`python -m takagi.cli`: the same as `takagi`."""

from __future__ import annotations

import sys

from takagi.cli.main import main

if __name__ == "__main__":
    sys.exit(main())

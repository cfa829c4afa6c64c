"""The command `takagi` on a path, for tests that run a shell."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def path_with_takagi(folder: Path) -> str:
    """Return a PATH on which ``takagi`` is this checkout's, and ``python3`` the tests' Python."""
    folder.mkdir(exist_ok=True)
    script = folder / "takagi"
    script.write_text(
        f'#!/bin/sh\nexec "{sys.executable}" -c '
        '"import sys; from takagi.cli.main import main; sys.exit(main(sys.argv[1:]))" "$@"\n'
    )
    script.chmod(0o755)
    return f"{folder}{os.pathsep}{os.environ['PATH']}"

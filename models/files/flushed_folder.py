"""A folder whose entries are safe on disk."""

from __future__ import annotations

import os
from pathlib import Path


def flush_folder(folder: Path) -> None:
    """Write the entries of a folder to disk.

    A new or renamed file survives a power failure only after its folder is flushed too.  Windows
    cannot open folders and needs no flush.
    """
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)

"""A lock that allows one writer for a file; it ends with the process that holds it."""

from __future__ import annotations

import sys


def hold(handle: int) -> bool:
    """Lock an open file for this process until it is closed; False if another process holds it.

    Windows has no lock of this kind on a whole file, and no lock is taken there.
    """
    if sys.platform == "win32":
        return True
    import fcntl

    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True

"""The meaning of operating system errors for a user, and what to do about each."""

from __future__ import annotations

import errno
import os

_ADVICE = {
    errno.ENOSPC: "the disk is full; free some space or choose another place",
    errno.EDQUOT: "your disk quota is used up; free some space or choose another place",
    errno.EROFS: "the file system is read-only; choose another place",
    errno.EACCES: "permission denied; check the permissions or choose another place",
    errno.EPERM: "the system does not permit it; check the permissions or choose another place",
    errno.ENOENT: "no such file or folder; check the path",
    errno.EEXIST: "a file of this name stands where a folder is needed; choose another name",
    errno.EISDIR: "this is a folder, and a file was expected",
    errno.ENOTDIR: "a part of this path is a file, and a folder was expected",
    errno.ENAMETOOLONG: "the name is too long for this file system; choose a shorter one",
}


def explain(error: OSError) -> str:
    """Return what happened and what to do, in one line, after the path if it is known."""
    what = _ADVICE.get(error.errno or 0, error.strerror or str(error))
    path = error.filename2 or error.filename
    return f"{os.fsdecode(path)}: {what}" if isinstance(path, str | bytes | os.PathLike) else what

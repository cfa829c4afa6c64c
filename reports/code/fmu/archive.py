"""The FMU file: an archive of description, sources and library; equal content gives equal bytes."""

from __future__ import annotations

import io
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

COMPILERS = ("cc", "gcc", "clang")
# -ffp-contract=off: a * b + c is rounded twice, as in Python, on every processor.
FLAGS = ("-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off")
EPOCH = (1980, 1, 1, 0, 0, 0)


class Library(NamedTuple):
    """A compiled library, or the reason why there is none.

    Attributes
    ----------
    platform : its name in FMI 3.0, such as x86_64-linux.
    folder : its name in FMI 2.0; None for a platform without a name there.
    """

    platform: str
    folder: str | None
    suffix: str
    content: bytes | None
    why_not: str = ""


def library(sources: Mapping[str, str], compiled: Iterable[str]) -> Library:
    """Return the sources compiled for this platform by the system's compiler.

    Parameters
    ----------
    sources : file name -> text; ``compiled`` names those that are no headers.
    """
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(
        platform.machine().lower(), platform.machine().lower()
    )
    folder = {"windows": "win64", "darwin": "darwin64", "linux": "linux64"}[system]
    suffix = {"windows": ".dll", "darwin": ".dylib", "linux": ".so"}[system]
    place = Library(f"{machine}-{system}", folder if machine == "x86_64" else None, suffix, None)
    compiler = next(filter(None, map(shutil.which, COMPILERS)), None)
    if compiler is None:
        return place._replace(why_not=f"no C compiler was found ({', '.join(COMPILERS)})")
    with tempfile.TemporaryDirectory() as folder_name:
        for name, text in sources.items():
            Path(folder_name, name).write_text(text, encoding="utf-8")
        # The names have no folders, so that the library does not contain the folder's path.
        command = [compiler, *FLAGS, *compiled, "-o", f"made{suffix}", "-lm"]
        done = subprocess.run(
            command, cwd=folder_name, capture_output=True, text=True, errors="replace", check=False
        )
        if done.returncode != 0:
            said = (done.stderr.strip() or "it says nothing").splitlines()[0]
            return place._replace(why_not=f"{compiler} could not compile them: {said}")
        return place._replace(content=Path(folder_name, f"made{suffix}").read_bytes())


def archive(files: Mapping[str, bytes | str]) -> bytes:
    """Return a zip archive of the files in their order, with one fixed time."""
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w") as opened:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = 0o100644 << 16
            opened.writestr(entry, data)
    return written.getvalue()

"""`takagi export --to fmu`: the law as FMUs of FMI 3.0 and 2.0.

The archive has description, sources and library; equal content gives equal bytes.
"""

from __future__ import annotations

import hashlib
import io
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from html import escape
from importlib.resources import files as package_files
from pathlib import Path
from typing import NamedTuple

from takagi.reports.code.c.source import c_source
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.fmu.description import FmuModel, fmu_model, model_description, model_header
from takagi.reports.code.target_text import filled
from takagi.reports.code.targets import Exported, ExportSettings

COMPILERS = ("cc", "gcc", "clang")
# -ffp-contract=off: a * b + c is rounded twice, as in Python, on every processor.
FLAGS = ("-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off")
EPOCH = (1980, 1, 1, 0, 0, 0)


class Library(NamedTuple):
    """A compiled library, or the reason why there is none.

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

    sources : file name -> text; ``compiled`` names those that are no headers.
    """
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(
        platform.machine().lower(), platform.machine().lower()
    )
    folder = {"windows": "win64", "darwin": "darwin64", "linux": "linux64"}[system]
    suffix = {"windows": ".dll", "darwin": ".dylib", "linux": ".so"}[system]
    target = Library(f"{machine}-{system}", folder if machine == "x86_64" else None, suffix, None)
    compiler = next(filter(None, map(shutil.which, COMPILERS)), None)
    if compiler is None:
        return target._replace(why_not=f"no C compiler was found ({', '.join(COMPILERS)})")
    with tempfile.TemporaryDirectory() as folder_name:
        for name, text in sources.items():
            Path(folder_name, name).write_text(text, encoding="utf-8")
        # The names have no folders, so that the library does not contain the folder's path.
        command = [compiler, *FLAGS, *compiled, "-o", f"made{suffix}", "-lm"]
        process = subprocess.run(
            command, cwd=folder_name, capture_output=True, text=True, errors="replace", check=False
        )
        if process.returncode != 0:
            first_line = (process.stderr.strip() or "it says nothing").splitlines()[0]
            return target._replace(why_not=f"{compiler} could not compile them: {first_line}")
        return target._replace(content=Path(folder_name, f"made{suffix}").read_bytes())


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


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return ``W.fmu`` and ``W_fmi2.fmu``.

    Raises ModelError: a name, number or sample time that C or the law cannot hold.
    """
    model = fmu_model(program, c_source(program, settings))
    files: dict[str, bytes | str] = {}
    use: dict[str, str] = {}
    for version, ending in ((3, ""), (2, "_fmi2")):
        name = f"{model.c.word}{ending}.fmu"
        files[name], content_words = _fmu(model, version)
        use[name] = f"FMI {version}.0 co-simulation: the law, {content_words}"
    return Exported(files, use)


def fmu_sources(model: FmuModel, version: int) -> tuple[dict[str, str], str]:
    """Return file name -> text of an FMU's sources, and the token of exactly these sources."""
    package = package_files("takagi.reports.code.fmu")
    word = model.c.word
    texts = {f"{word}.c": model.c.source, f"fmi{version}.c": "", f"{word}.h": model.c.header}
    for name in (f"fmi{version}.c", "runner.h"):
        texts[name] = (package / name).read_text(encoding="utf-8")
    content = "\n".join((*texts.values(), model_header(model, "")))
    digest = hashlib.sha256(content.encode()).hexdigest()
    token = f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"
    return {**texts, "model.h": model_header(model, token)}, token


def _fmu(model: FmuModel, version: int) -> tuple[bytes, str]:
    """Return the file, and what is in it in words."""
    sources, token = fmu_sources(model, version)
    compiled = [name for name in sources if name.endswith(".c")]
    compiled_library = library(sources, compiled)
    files: dict[str, bytes | str] = {}
    files["modelDescription.xml"] = model_description(model, version, token, compiled)
    if version == 3:
        context = {"model": model, "sources": compiled}
        files["sources/buildDescription.xml"] = filled("fmu", "buildDescription.xml", context)
    page = {"escape": escape, **model.c.context}
    files["documentation/index.html"] = filled("fmu", "index.html", page)
    files |= {f"sources/{name}": text for name, text in sources.items()}
    binaries_folder = compiled_library.platform if version == 3 else compiled_library.folder
    if compiled_library.content is not None and binaries_folder is not None:
        files[f"binaries/{binaries_folder}/{model.c.word}{compiled_library.suffix}"] = (
            compiled_library.content
        )
        return archive(files), f"with sources and a library for {binaries_folder}"
    why = compiled_library.why_not or f"FMI 2.0 has no word for {compiled_library.platform}"
    return archive(files), f"sources alone, which your tool has to compile: {why}"

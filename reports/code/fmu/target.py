"""`takagi export --to fmu`: the law as FMUs of FMI 3.0 and 2.0."""

from __future__ import annotations

import hashlib
from importlib.resources import files as package_files

from takagi.reports.code.c.source import c_source
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.fmu.archive import Library, archive, library
from takagi.reports.code.fmu.description import (
    build_description,
    model_description_2,
    model_description_3,
)
from takagi.reports.code.fmu.model_source import FmuModel, fmu_model, model_header
from takagi.reports.code.targets import Exported, ExportSettings


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return ``W.fmu`` and ``W_fmi2.fmu``.

    Raises
    ------
    ModelError : a name, number or sample time that C or the law cannot hold.
    """
    model = fmu_model(program, c_source(program, settings))
    files: dict[str, bytes | str] = {}
    use: dict[str, str] = {}
    for version, ending in ((3, ""), (2, "_fmi2")):
        name = f"{model.word}{ending}.fmu"
        files[name], held = _fmu(model, version)
        use[name] = f"FMI {version}.0 co-simulation: the law, {held}"
    return Exported(files, use)


def fmu_sources(model: FmuModel, version: int) -> tuple[dict[str, str], str]:
    """Return file name -> text of an FMU's sources, and the token of exactly these sources."""
    package = package_files("takagi.reports.code.fmu")
    word = model.c.word
    found = {f"{word}.c": model.c.source, f"fmi{version}.c": "", f"{word}.h": model.c.header}
    for name in (f"fmi{version}.c", "runner.h"):
        found[name] = (package / name).read_text(encoding="utf-8")
    content = "\n".join((*found.values(), model_header(model, "")))
    digest = hashlib.sha256(content.encode()).hexdigest()
    token = f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"
    return {**found, "model.h": model_header(model, token)}, token


def _fmu(model: FmuModel, version: int) -> tuple[bytes, str]:
    """Return the file, and what is in it in words."""
    sources, token = fmu_sources(model, version)
    compiled = [name for name in sources if name.endswith(".c")]
    made = library(sources, compiled)
    files: dict[str, bytes | str] = {}
    if version == 3:
        files["modelDescription.xml"] = model_description_3(model, token)
        files["sources/buildDescription.xml"] = build_description(model, compiled)
    else:
        files["modelDescription.xml"] = model_description_2(model, token, compiled)
    files |= {f"sources/{name}": text for name, text in sources.items()}
    place = _place(made, version)
    if made.content is not None and place is not None:
        files[f"binaries/{place}/{model.word}{made.suffix}"] = made.content
        return archive(files), f"with sources and a library for {place}"
    why = made.why_not or f"FMI 2.0 has no word for {made.platform}"
    return archive(files), f"sources alone, which your tool has to compile: {why}"


def _place(made: Library, version: int) -> str | None:
    return made.platform if version == 3 else made.folder

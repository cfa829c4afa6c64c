"""`takagi export --to fmu`: the law as FMUs of FMI 3.0 and 2.0.

The archive has modelDescription.xml, sources and library; equal content gives equal bytes.
"""

from __future__ import annotations

import hashlib
import io
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from decimal import Decimal
from html import escape
from importlib.resources import files as package_files
from pathlib import Path
from typing import Any, NamedTuple
from xml.sax.saxutils import quoteattr

from takagi.models.errors import ModelError
from takagi.models.files.units import BASE, parse_unit
from takagi.reports.code.c.source import CSource, c_source
from takagi.reports.code.controller_program import ControllerProgram, Signal, identifiers
from takagi.reports.code.targets import Exported, ExportSettings, filled, proof_lines

# Role -> causality, variability, and how the start is found ("" where that is implied).
KINDS = {
    "time": ("independent", "continuous", ""),
    "parameter": ("parameter", "fixed", "exact"),
    "input": ("input", "continuous", ""),
    "output": ("output", "discrete", "calculated"),
    "kept": ("local", "discrete", "calculated"),
}


def model_description(model: FmuModel, version: int, token: str, sources: Iterable[str]) -> str:
    """Return modelDescription.xml of FMI 2.0 or 3.0; ``sources`` are what a tool compiles."""
    gains = model.program.hashes.get("gains")
    units = dict.fromkeys(v.unit for v in model.variables if v.unit not in ("", "-"))
    status = len(model.variables)
    bits = ", ".join(
        f"{bit} {word.replace('_', ' ').lower()}"
        for word, bit in sorted(model.c.status_bits.items(), key=lambda pair: pair[1])
    )
    words = f"of the last sample, a sum of: {bits}; 0 where all is well"
    context = {
        "model": model,
        "version": version,
        "token": token,
        "sources": sources,
        "proof": " ".join(proof_lines(model.program))
        + (f", SHA-256 of its gains {gains}" if gains else ""),
        "units": [(unit, base_units(unit)) for unit in units],
        "step": float(model.c.sample_time),
        "variables": [
            (_kind(variable.name, k, variable.role, variable.description), _real(variable))
            for k, variable in enumerate(model.variables)
        ],
        "status": _kind("status", status, "output", words),
        "outputs": [
            *(k for k, variable in enumerate(model.variables) if variable.role == "output"),
            status,
        ],
        "quoted": quoteattr,
        "attributes": lambda values: "".join(
            f" {key}={quoteattr(str(value))}" for key, value in values.items()
        ),
    }
    return filled("fmu", "modelDescription.xml", context)


def _kind(name: str, reference: int, role: str, description: str) -> dict[str, Any]:
    causality, variability, initial = KINDS[role]
    stated = {
        "name": name,
        "valueReference": reference,
        "causality": causality,
        "variability": variability,
        "initial": initial,
        "description": description,
    }
    return {key: value for key, value in stated.items() if value != ""}


def _real(variable: Variable) -> dict[str, Any]:
    attributes = {} if variable.unit in ("", "-") else {"unit": variable.unit}
    start = variable.start
    return attributes if start is None else {**attributes, "start": float(start)}


def base_units(unit: str) -> dict[str, int] | None:
    """Return the exponents of kg, m, s, A, K, mol, cd and rad that are not 0.

    None for a text that is no SI unit; signals of a gain file are in SI.
    """
    try:
        parsed = parse_unit(unit)
    except ModelError:
        return None
    powers = parsed.dimension.exponents
    if not parsed.is_si or any(power.denominator != 1 for power in powers):
        return None
    exponents = {name: int(power) for name, power in zip(BASE, powers, strict=True)}
    exponents["rad"] = _radians(unit)
    return {name: power for name, power in exponents.items() if power}


def _radians(unit: str) -> int:
    """Return the exponent of rad, which is a pure number in SI and a base unit in FMI."""
    above, _, below = unit.partition("/")

    def count(text: str) -> int:
        return sum(int(power or 1) for power in re.findall(r"\brad\b(?:\^(-?\d+))?", text))

    return count(above) - count(below)


RESERVED = ("time", "sample_time", "status")


class Variable(NamedTuple):
    """A variable of the FMU; its place in the list is its value reference.

    Attributes
    ----------
    key : its name in the law; ``name`` is its name in the FMU.
    role : "time", "parameter", "input", "output" or "kept".
    start : value at the start, SI; None where the model computes it.
    """

    key: str
    name: str
    role: str
    unit: str
    description: str
    start: Decimal | None = None


class FmuModel(NamedTuple):
    """A law as an FMU: ``variables`` are all real ones; the status follows them."""

    program: ControllerProgram
    c: CSource
    variables: tuple[Variable, ...]


def fmu_model(program: ControllerProgram, c: CSource) -> FmuModel:
    """Return the law as a model."""
    keys = [s.name for s in (*program.inputs, *program.outputs)] + [k.name for k in program.kept]
    names = identifiers(keys, RESERVED, language="an FMU")
    what = "from one sample of the law to the next"
    variables = [
        Variable("time", "time", "time", "s", ""),
        Variable("sample_time", "sample_time", "parameter", "s", what, c.sample_time),
    ]
    for s in program.inputs:
        meaning, start = _meaning(s, program), s.rest or Decimal(0)
        variables.append(Variable(s.name, names[s.name], "input", s.unit, meaning, start))
    for role, entries in (("output", program.outputs), ("kept", program.kept)):
        variables += [Variable(s.name, names[s.name], role, s.unit, s.meaning) for s in entries]
    return FmuModel(program, c, tuple(variables))


def _meaning(signal: Signal, program: ControllerProgram) -> str:
    """Return the meaning of a signal, with the range in which the model holds."""
    sentences = [signal.meaning]
    for state in program.document.get("states", ()):
        if isinstance(state, Mapping) and state.get("name") == signal.name:
            sentences.append(str(state.get("description") or ""))
    if signal.range is not None:
        sentences.append(f"the model holds in [{signal.range[0]}, {signal.range[1]}]")
    return "; ".join(sentence for sentence in sentences if sentence)


def model_header(model: FmuModel, token: str) -> str:
    """Return ``model.h``; an importer must pass ``token`` to show that it has this description."""
    bits = model.c.status_bits
    own = {
        "token": token,
        "variables": model.variables,
        "at": {variable.key: f"AT_{variable.name}" for variable in model.variables},
        "law": model.c,
        "normal": bits["AT_LIMIT"] | bits["ESTIMATE_HELD"],
    }
    return filled("fmu", "model.h", {**model.c.context, **own})


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

    Raises
    ------
    ModelError : a name, number or sample time that C or the law cannot hold.
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

"""Models as files and as their certificates have them, recorded, and what is said of both.

``files.json`` holds three plants (a cart with tables and a mass matrix, a plant with a sample time,
one with a blend) and a turbine, each as its files and as its certificate has it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from takagi.certificates.checker.files.given_files import compare_model
from tests.certificates.pinned.turbine.inputs import Document, as_read
from tests.certificates.pinned.turbine.values import said

FILES = Path(__file__).with_name("files.json")


PLANTS, TURBINES = ("cart", "step", "room"), ("turbine", "factor")


_RECORDED: Document = json.loads(FILES.read_text(encoding="utf-8"))


def texts_of(name: str) -> dict[str, str]:
    """Return the files of a model, the model's own first."""
    found: dict[str, str] = dict(_RECORDED[name]["files"])
    return found


def certificate(name: str) -> Document:
    """Return model, gains, claims and controller as the checker reads them."""
    found = {key: deepcopy(part) for key, part in _RECORDED[name].items() if key != "files"}
    found["provenance"] = {"sha256": {"model": "m", "gains": "g", "claims": "c"}}
    return as_read(found)


# What the standard library says of a file is not the checker's, and changes with its version.
LIBRARY = re.compile(r"(not (?:a \w[\w ]* file|JSON|a coefficient table): |zip\(\)).*")


def own_words(sentence: str) -> str:
    """Return a sentence without what the standard library says in it."""
    return LIBRARY.sub(r"\1...", sentence)


def answer(data: Document, texts: dict[str, str], work: Callable[..., Any] = compare_model) -> Any:
    """Return what is said of these files, the first of them the model's, without its folder."""
    with TemporaryDirectory() as folder:
        for file, text in texts.items():
            (Path(folder) / file).write_bytes(text.encode())
        found = said(work, data, Path(folder) / next(iter(texts)))
        return own_words(found.replace(folder, "")) if isinstance(found, str) else found


def model_of(name: str) -> Any:
    """Return a recorded certificate's model as plain data."""
    return _RECORDED[name]["model"]

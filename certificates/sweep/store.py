"""The store of tasks: one result a file, named by the hash of its task.

    FOLDER/HASH.json    {"task": {...}, "sha256": hash of the result, "result": {...}}

A file is written beside its place and renamed, so it is complete or absent.  A task whose file is
there is not computed again; a damaged file counts as absent.  The hash covers everything that the
result depends on, so a file of another model, law or release is never taken for this task's.
"""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

from takagi.certificates.document.certificate_file import provenance
from takagi.models.errors import ModelError

# To be increased where a function returns something else for the same inputs.
FORMAT = 1
RESULTS = "results"

Result = dict[str, Any]


@dataclass(frozen=True)
class Task:
    """One result to compute.

    Attributes
    ----------
    function : ``module:name`` of a function ``name(source, inputs) -> Result`` at the top of a
        module; the result is JSON without NaN.
    source : where the function finds its file; not part of the hash.
    inputs : everything that the result depends on, as JSON; of ``source`` its SHA-256.
    files : what a worker of a cluster needs to read ``source``, which is there the first of them,
        beside the others; not part of the hash.
    """

    function: str
    source: str
    inputs: Mapping[str, Any]
    files: tuple[Path, ...] = ()

    @cached_property
    def hashed(self) -> str:
        """What the hash covers, as JSON."""
        covered = {"format": FORMAT, "function": self.function, "inputs": self.inputs}
        return canonical({**covered, "versions": provenance({}, {})["versions"]})

    @property
    def file(self) -> str:
        """The name of the result's file."""
        return f"{_sha256(self.hashed)}.json"


def canonical(value: Any) -> str:
    """Return JSON that is the same for the same value.

    Raises
    ------
    TypeError, ValueError : a value that JSON cannot represent, such as NaN or infinity.
    """
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def stored_result(task: Task, folder: Path) -> Result | None:
    """Return the result in the task's file; None if there is none, or if it is damaged."""
    try:
        content = json.loads((folder / task.file).read_text(encoding="utf-8"))
        result = content["result"]
        same = canonical(content["task"]) == task.hashed
        if same and content["sha256"] == _sha256(canonical(result)) and isinstance(result, dict):
            return result
    except (OSError, ValueError, TypeError, KeyError):
        # Whatever is there instead is replaced; what cannot be replaced is told at writing.
        return None
    return None


def require_same_study(tasks: Sequence[Task], folder: Path) -> None:
    """Refuse a folder with a result of another function, or of another release or library."""
    ours, functions = {task.file for task in tasks}, {task.function for task in tasks}
    here = json.loads(tasks[0].hashed)["versions"]
    for path in sorted(folder.glob("*.json")):
        if path.name in ours:
            continue
        try:
            stated = json.loads(path.read_text(encoding="utf-8"))["task"]
            function, there = stated["function"], dict(stated["versions"])
        except (OSError, ValueError, TypeError, KeyError):
            continue
        if function not in functions:
            words = f"a result of another study ({function})"
        elif differing := version_differences(there, here):
            words = f"a result of other versions: {differing}"
        else:
            continue
        raise ModelError(
            f"{folder} has {words}; nothing of it can be used here: give another folder, or "
            "remove this one"
        )


def version_differences(there: Mapping[str, str], here: Mapping[str, str]) -> str:
    """Return which versions differ, in words; empty if none does."""
    return ", ".join(
        f"{name} {there.get(name, 'missing')} (here {here.get(name, 'missing')})"
        for name in dict.fromkeys((*here, *there))
        if there.get(name) != here.get(name)
    )


def store_result(task: Task, folder: Path, text: str) -> Result:
    """Write the result's file unless the result is an error; return the result as it is read."""
    result: Result = json.loads(text)
    if "error" in result:
        return result
    checksum = _sha256(canonical(result))
    content = f'{{"task":{task.hashed},"sha256":"{checksum}","result":{text}}}\n'
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".result-", dir=folder) as beside:
        with open(Path(beside) / task.file, "w", encoding="utf-8") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(file.name, folder / task.file)
    return result


def result_text(function: str, source: str, inputs: Mapping[str, Any]) -> str:
    """Return the result of a task as JSON; ``{"error": words}`` of what ended in an error."""
    try:
        module, _, name = function.partition(":")
        result = getattr(import_module(module), name)(source, inputs)
        return json.dumps(result, separators=(",", ":"), allow_nan=False)
    except Exception as error:
        return json.dumps({"error": f"{type(error).__name__}: {' '.join(str(error).split())}"})

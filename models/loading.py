"""The reader of model files: a built-in name or a path, read once.

``read_model`` returns the file as a value: its kind, its document, the files beside it, and the
model, made when it is asked for.  A verb reads it at its door and passes it on.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.models.plant.plant import Plant
    from takagi.models.plant_files.loader import PlantFile
    from takagi.models.turbine.data import Turbine
    from takagi.models.turbine.loader import TurbineFile

    ModelFile: TypeAlias = PlantFile | TurbineFile


def read_model(name_or_path: str | Path) -> ModelFile:
    """Return the file of a built-in name or path, read once.

    Raises
    ------
    ModelError : no such model, a file that is not TOML, or one that states no kind of model.
    """
    from takagi.models.files.library import decimal_of, kind_of, read_document, resolve_model

    if Path(name_or_path).suffix.lower() == ".mat":
        raise ModelError(
            f"{name_or_path} is a MAT-file, and a TOML file is needed here: `takagi new plant.toml "
            f"--from-mat {name_or_path}` writes it (in Python load_ts_model reads its vertices)"
        )
    document = read_document(resolve_model(name_or_path), parse_float=decimal_of)
    if kind_of(document) == "plant":
        from takagi.models.plant_files.loader import PlantFile

        return PlantFile(name_or_path, document)
    from takagi.models.turbine.loader import TurbineFile

    return TurbineFile(name_or_path, document.in_floats())


def load_model(name_or_path: str | Path) -> Plant | Turbine:
    """Return the model of a built-in name (``"nrel5mw"``) or of a TOML file.

    A file with ``kind = "plant"`` gives a ``Plant``, one with ``kind = "turbine"`` a ``Turbine``.

    Raises
    ------
    ModelError : neither a built-in name nor a readable file, a file of another kind, or one that
        is malformed; the message names file, line, field and what was expected.
    """
    return read_model(name_or_path).model

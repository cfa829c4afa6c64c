"""One door for models in files: a built-in name or a path."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.models.plant.plant import Plant
    from takagi.models.turbine.data import Turbine

__all__ = ["load_model"]


def load_model(name_or_path: str | Path) -> Plant | Turbine:
    """Return the model of a built-in name (``"nrel5mw"``) or of a TOML file.

    A file with ``kind = "plant"`` gives a ``Plant``, one with ``kind = "turbine"`` a ``Turbine``.

    Raises
    ------
    ModelError : neither a built-in name nor a readable file, a file of another kind, or one that
        is malformed; the message names file, line, field and what was expected.
    """
    from takagi.models.files.library import resolve_model
    from takagi.models.files.toml_document import read_document

    document = read_document(resolve_model(name_or_path))
    kind = document.data.get("kind")
    if kind == "plant":
        from takagi.models.plant_files.loader import load_plant

        return load_plant(name_or_path)
    if kind == "turbine":
        from takagi.models.turbine.loader import load_turbine

        return load_turbine(name_or_path)
    raise document.error(
        "kind", f'{kind!r} was given; a model file says kind = "plant" or kind = "turbine"'
    )

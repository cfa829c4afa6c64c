"""One door for models in files: a built-in name or a path."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.models.turbine.data import Turbine

__all__ = ["load_model"]


def load_model(name_or_path: str | Path) -> Turbine:
    """Return the turbine of a built-in name (``"nrel5mw"``) or of a TOML file.

    Raises
    ------
    ModelError : neither a built-in name nor a readable file, or a file that is malformed; the
        message names file, line, field and what was expected.
    """
    from takagi.models.library import resolve_model
    from takagi.models.turbine.loader import load_turbine

    return load_turbine(resolve_model(name_or_path))

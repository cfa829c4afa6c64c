"""The floor's front door: fixed names, nothing heavy imported."""

from __future__ import annotations

import pytest

import takagi.models
from takagi.models import ModelError, Turbine, load_model, nrel5mw


def test_the_fixed_names_are_exported() -> None:
    """Every listed name resolves; ``import *`` gives the same names as dir()."""
    names = dir(takagi.models)
    starred: dict[str, object] = {}
    exec("from takagi.models import *", starred)

    assert {"TSModel", "Premise", "sector_model", "load_model", "nrel5mw", "ModelError"} <= set(
        names
    )
    assert all(getattr(takagi.models, name) is starred[name] for name in names)
    assert set(starred) == {*names, "__builtins__"}


def test_an_unknown_name_is_an_attribute_error() -> None:
    """The lazy lookup refuses names it does not know as a module would."""
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = takagi.models.nonsense


def test_load_model_reads_a_built_in_turbine() -> None:
    """The built-in name gives the same figures as the named function."""
    found = load_model("nrel5mw")

    assert isinstance(found, Turbine)
    assert found.inertia == nrel5mw().inertia


def test_load_model_offers_near_names() -> None:
    """A misspelt name is answered with the right one."""
    with pytest.raises(ModelError, match="nrel5mw"):
        load_model("nrel5mv")

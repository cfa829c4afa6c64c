"""The two regional models of the NREL 5-MW turbine, made once for all tests of the paper's law."""

from __future__ import annotations

from functools import cache

from takagi.models import TSModel, full_load_model, nrel5mw, partial_load_model


@cache
def regional_models() -> tuple[TSModel, TSModel]:
    """Return partial and full load with coarse (still rigorous) bounds: faster to make."""
    models = partial_load_model, full_load_model
    partial, full = (model(nrel5mw(), tolerance="0.1") for model in models)
    return partial, full

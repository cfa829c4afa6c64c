"""`takagi models`: list the built-in models."""

from __future__ import annotations

import json
from functools import partial

from takagi.cli.command import PROVED, run_command


def list_models(as_json: bool = False) -> int:
    """List the built-in models: wind turbines, then plants."""
    from takagi.models.files.library import built_in_kinds, built_in_models

    kinds = built_in_kinds()
    models = sorted(built_in_models(), key=lambda pair: (kinds[pair[0]] != "turbine", pair[0]))
    if as_json:
        rows = [{"name": name, "kind": kinds[name], "description": text} for name, text in models]
        print(json.dumps(rows, indent=2))
        return PROVED
    width = max((len(name) for name, _ in models), default=0)
    for name, text in models:
        print(f"{name:<{width}}  {kinds[name]:<7}  {text}")
    return PROVED


run = partial(run_command, "models", list_models)

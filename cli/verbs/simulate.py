"""`takagi simulate`: laws on the nonlinear plant, of a turbine side by side in the same winds."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.cli.command import run_command
from takagi.cli.options.given import Options
from takagi.cli.options.turbine_options import ModelOrFolder
from takagi.cli.runs.makers import MAKERS, own_options

if TYPE_CHECKING:
    pass


def run(arguments: Sequence[str]) -> int:
    """Run the verb; return its exit status."""
    # Turbines and plants share some.
    every = {option.name: option for options in _declared().values() for option in options}
    return run_command("simulate", simulate, arguments, options=tuple(every.values()))


def _declared() -> dict[str, Options]:
    """Return kind of model -> the options that its simulation has."""
    return {kind: import_module(maker.simulation).OPTIONS for kind, maker in MAKERS.items()}


def simulate(
    model: ModelOrFolder,
    out: Path | None = None,
    *,
    duration: float | None = None,
    as_json: bool = False,
    **options: Any,
) -> int:
    """Simulate laws on the nonlinear plant. A simulation proves nothing."""
    from takagi.models.loading import read_model

    gains: Path | None = None
    if Path(model).is_dir():
        from takagi.reports.design_folder import design_folder

        design = design_folder(Path(model))
        source, gains = read_model(design.model), design.gains
    else:
        source = read_model(model)
    if gains is not None and options["certificate"] is None:
        # A plant's design is read whole, so that nothing is proved again.
        name, given = ("gains", Path(model)) if source.kind == "plant" else ("law_from", gains)
        options[name] = options[name] or given
    requested = own_options(source, options, _declared())
    status: int = import_module(MAKERS[source.kind].simulation).simulate(
        source, out, requested, duration=duration, as_json=as_json
    )
    return status

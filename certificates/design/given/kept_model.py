"""Gains of a file for a plant that has changed: the file's own model is kept if possible.

The law u = u* - sum_j g_j K_j (x - x*) has the weights g of the file: its premises with their
bounds.  A changed plant may be derived with other premises.  There are two ways to prove the law:

1.  the model is derived anew with the premises and bounds of the file, so that model and law have
    the same weights: the new equations are the blend of new vertices in the old premises;
2.  if that is impossible (a term needs another premise, or a range exceeds its bounds), the model
    has its own premises and the law its own weights. The proof then holds for any weights of the
    law, because every vertex is combined with every gain.  This is a stronger requirement.

The notes give the reason why the first way is impossible.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.kernel.reader import digest, read_json
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.controller.content import plain
from takagi.certificates.design.given.changed_plant import misfits
from takagi.certificates.design.given.plant_gains import read_gains, read_plant_law
from takagi.certificates.document.certificate_file import as_read, content_of, files_sha256
from takagi.models.arrays import Floats
from takagi.models.equations.ball import balls_of
from takagi.models.errors import ModelError
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant.plant import Plant

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.ts.model import TSModel

# Members of the law that must agree with the plant, whatever the premises are.
SHARED = ("sample_time", "state_names", "input_names", "trim")


@dataclass(frozen=True, slots=True, eq=False)
class GivenLaw:
    """The model for the proof, the gains, and the law if it has its own weights.

    Attributes
    ----------
    gains : (r, m, n) if the law has the model's weights; (s, m, n) if it has its own.
    law : as the file states it; None if it has the weights of the model.
    notes : texts on the way that was used, and why the other was impossible.
    """

    model: TSModel
    gains: Floats
    law: Mapping[str, Any] | None
    notes: tuple[str, ...]


def law_for(
    plant: Plant, model: TSModel, path: Path, settings: PlantSettings, *, files: Sequence[Path] = ()
) -> GivenLaw:
    """Return the model and law with which the gains of a file are proved on a plant.

    Parameters
    ----------
    model : of the plant, derived without the gain file.
    files : the data files of the plant.  A gain file that was written for them needs the model
        that was derived then; if its law differs, it is refused.

    Raises
    ------
    CertificateError : the file is unreadable, has no law of a plant, or one for other states,
        inputs, rest values or sample time.
    """
    try:
        return GivenLaw(model, read_gains(path, model), None, ("gains were given",))
    except CertificateError as error:
        first = error
    if _is_of(model, path, files):
        raise first
    law = plain(read_plant_law(path))
    try:
        kept = _derived(plant, law, settings)
        K = read_gains(path, kept)
    except (ModelError, CertificateError) as reason:
        return _own_weights(model, law, path, first, str(reason))
    return GivenLaw(kept, K, None, ("gains were given", "the premises of their file were kept"))


def _derived(plant: Plant, law: Mapping[str, Any], settings: PlantSettings) -> TSModel:
    """Return the model in the premises of the law, with the law's bounds."""
    from takagi.models.sector.model import sector_model

    if plant.blending is not None:
        raise ModelError("premises of a plant behind a blend are not kept")
    premises = _premises(plant, law)
    bounds = {
        symbol: (_number(p["lower"]), _number(p["upper"]))
        for symbol, p in zip(premises, law.get("premises", []), strict=True)
    }
    return sector_model(
        replace(plant, premises={}),
        rest=settings.rest,
        choice=settings.choice,
        premises=premises,
        bounds=bounds,
    )


def _premises(plant: Plant, law: Mapping[str, Any]) -> dict[sp.Symbol, sp.Expr]:
    """Return the law's premises in the plant's own variables."""
    import sympy as sp

    from takagi.certificates.checker.plant.expression import NAME
    from takagi.models.expressions.parser import Scope, parse_expression

    variables = {v.name: v for v in plant.variables}
    symbols = {name: v.symbol for name, v in variables.items()}
    moved = {
        f"delta_{name}": sp.Symbol(f"delta_{name}", real=True)
        for name, v in variables.items()
        if v.rest != 0 and f"delta_{name}" not in variables
    }
    balls = balls_of(plant)
    symbols |= {ball.symbol.name: ball.symbol for ball in balls.values()}
    back = {}
    for name, symbol in moved.items():
        variable = variables[name.removeprefix("delta_")]
        ball = balls.get(variable.symbol)
        rest = sp.Rational(*variable.rest.as_integer_ratio()) if ball is None else ball.symbol
        back[symbol] = variable.symbol - rest
    found = {}
    for premise in law.get("premises", []):
        name, text = premise.get("name"), premise.get("expression")
        if not isinstance(text, str) or not isinstance(name, str) or not NAME.fullmatch(name):
            raise ModelError(f"premise {name!a} has no expression that could be kept")
        expression = parse_expression(text, Scope({**symbols, **moved}))
        found[sp.Symbol(name, real=True)] = expression.xreplace(back)
    if not found:
        raise ModelError("the law has no premises to keep")
    return found


def _number(value: float | int | str) -> str:
    return value if isinstance(value, str) else repr(value)


def _own_weights(
    model: TSModel, law: Mapping[str, Any], path: Path, first: CertificateError, reason: str
) -> GivenLaw:
    """Return the law with its own weights; it may differ from the model in its weights only."""
    from takagi.certificates.document.model_data import pdc_law_data
    from takagi.certificates.document.plant_embedding import law_members, plant_and_claim

    r, n, m = model.B.shape
    K = np.array(law["K"], dtype=np.float64)
    data = plant_and_claim(model)[0]
    if data is None or "blending" in law:
        raise first
    wanted = plain(pdc_law_data(model, np.zeros((m, n))) | law_members(data))
    apart = misfits(law, wanted)
    if apart:
        raise CertificateError(
            f"{path}: law.{_first_apart(law, wanted)} is not the model's, so the law cannot be run "
            f"on this plant: {'; '.join(apart)}"
        )
    if any(not _same(law.get(key), wanted.get(key)) for key in SHARED):
        raise first
    if K.ndim != 3 or K.shape[1:] != (m, n):
        raise first
    notes = (
        "gains were given",
        f"the premises of {path} are not kept: {reason}",
        "so the law has weights of its own: every vertex is taken with every gain",
    )
    return GivenLaw(model, K, law, notes)


def _is_of(model: TSModel, path: Path, files: Sequence[Path]) -> bool:
    """Return whether the file was written for this plant, so that its law was changed later."""
    from takagi.certificates.document.plant_embedding import plant_and_claim

    stated: Any = read_json(path)
    for key in ("certificate", "sha256", "model"):
        stated = stated.get(key) if isinstance(stated, Mapping) else None
    data = plant_and_claim(model)[0]
    if data is None:
        return False
    members = [content_of(files)]
    if files:
        # Older gain files have a digest that includes the bytes of the model's files.
        members.append({"files_sha256": files_sha256(files)})
    return any(stated == digest(as_read({**data, **more})) for more in members)


def _first_apart(law: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    return next((key for key in SHARED if not _same(law.get(key), wanted.get(key))), SHARED[0])


def _same(first: Any, second: Any) -> bool:
    """Return whether two plain values are the same; 1 and 1.0 are."""
    return bool(first == second)

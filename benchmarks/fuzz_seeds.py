"""Certificates of every kind of claim, small and true: what the fuzzer of the checker starts from.

A seed is a folder's worth of files: the certificate, and for some the gain file and the model's
files that it is checked with.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from takagi.certificates import certify
from takagi.certificates.claims.turbine.effort_sharing import (
    effort_sharing_candidate,
    effort_sharing_claim,
)
from takagi.certificates.claims.turbine.published import (
    published_candidate,
    published_claim,
    published_law_data,
)
from takagi.certificates.design.design import NoDesign
from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.document.certificate_file import (
    certificate_document,
    effort_sharing_law_data,
    turbine_data,
)
from takagi.certificates.requests import (
    Decay,
    FuzzyDecay,
    ObservedFeedback,
    ObserverError,
    Poles,
    Request,
)
from takagi.lmi import EigenvalueRegion, observer, pdc
from takagi.lmi.turbine.effort import effort_gains
from takagi.models import TSModel, sector_model
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.laws.published.coupling_filter import coupling_filter
from takagi.models.laws.published.law import published_law
from takagi.models.laws.published.regional_schedule import regional_schedule
from takagi.models.plant_files.loader import load_plant, plant_files
from takagi.models.turbine.full_load import full_load_model
from takagi.models.turbine.loader import model_files, nrel5mw
from takagi.models.turbine.partial_load import partial_load_model

CERTIFICATE, GAINS = "certificate.json", "gains.json"
Document = Mapping[str, Any]
PAIR = [[[-1.0, -1.0], [1.0, -1.0]], [[-1.0, -4.0], [0.25, -1.0]]]
LIBRARY = ("duffing", "cart_pole", "truck_trailer", "lorenz")
# A cell of the effort-sharing loop where the effort passes from torque to pitch.
FIRST_WIND, CELLS = 11.2, 2


def write_seeds(folder: Path, *, small: bool = False) -> list[Path]:
    """Write one folder a seed; return those folders.  ``small`` leaves out what takes longer."""
    made = []
    for name, seed in (_loops() if small else {**_loops(), **_turbines()}).items():
        made.append(folder / name)
        _write(made[-1], seed())
    for name in LIBRARY[:1] if small else LIBRARY:
        made.append(folder / name)
        _write_plant(made[-1], name)
    return made


def _loops() -> dict[str, Callable[[], Document]]:
    return {
        "everything": _everything,
        "observed": _observed,
        "secants": lambda: certify(secant_model(load_plant("duffing")), [[3.0, 3.0]]).document,
        "sampled": _sampled,
        "fuzzy": _fuzzy,
        "impossible": lambda: certify(TSModel([[[1.0, 1.0], [0.0, -1.0]], PAIR[0]])).document,
        "multipliers": lambda: certify(TSModel([PAIR[0], [[-1, -40.0], [0.025, -1]]])).document,
    }


def _turbines() -> dict[str, Callable[[], Document]]:
    return {"coherent": _coherent, "paper": _paper}


def _duffing() -> tuple[TSModel, Any]:
    model = sector_model(load_plant("duffing"))
    return model, np.round(pdc(model, decay_rate=0.5).require()[0], 3)


def _everything() -> Document:
    model, gains = _duffing()
    return certify(model, gains, claims="all").document


def _observed() -> Document:
    model, gains = _duffing()
    L = np.round(observer(model, decay_rate=1.0).require()[0], 3)
    claims: list[Request] = [
        Decay(),
        Poles(EigenvalueRegion.disc(40) & EigenvalueRegion.half_plane(0.1)),
        ObserverError(L),
        ObservedFeedback(L),
    ]
    return certify(model, gains, claims=claims).document


def _sampled() -> Document:
    A = [[[1.0, 0.1], [0.1, 1.0]], [[1.0, 0.1], [0.3, 0.95]]]
    E, B = [[0.0], [0.02]], [[0.0], [0.1]]
    model = TSModel(A, B, C=[[1.0, 0.0]], E=E, sample_time=0.1)
    return certify(model, [[4.0, 3.0]], claims="all").document


def _fuzzy() -> Document:
    return certify(TSModel(PAIR), claims=[FuzzyDecay(0.1)]).document


def _coherent() -> Document:
    turbine = nrel5mw()
    schedule = effort_schedule(turbine)
    law = EffortSharingLaw.of(turbine, schedule, effort_gains(turbine, schedule).gains)
    gains, claim = (
        effort_sharing_law_data(law),
        effort_sharing_claim(effort_sharing_candidate(turbine, law)),
    )
    first = next(k for k, v in enumerate(gains["wind"]) if v >= FIRST_WIND)
    for name, column in gains.items():
        if isinstance(column, list):
            gains[name] = column[first : first + CELLS + (name != "integral_rate")]
    claim = dict(claim) | {"cells": claim["cells"][first : first + CELLS]}
    model = turbine_data(turbine, model_files("nrel5mw"))
    return certificate_document(model=model, gains=gains, claims=[claim], provenance={})


def _paper() -> Document:
    turbine = nrel5mw()
    partial = regional_schedule(
        turbine,
        partial_load_model(turbine, tolerance="0.1"),
        k_x=np.repeat([-75_500.0, -84_700.0], 2)[:, None],
        k_I=np.repeat([-9_900.0, -8_500.0], 2),
    )
    full = regional_schedule(
        turbine,
        full_load_model(turbine, tolerance="0.1"),
        k_x=np.repeat([[-0.43, -0.52], [-0.32, -0.67], [-0.47, -0.55], [-0.41, -0.65]], 2, 0),
        k_I=np.repeat([-0.080, -0.079, -0.065, -0.083], 2),
    )
    coupling = coupling_filter(turbine, placement=0.5)
    law = published_law(turbine, partial=partial, full=full, coupling=coupling, name="paper")
    claim = dict(published_claim(published_candidate(law, winds=((6.0, 6.06), (13.0, 13.06)))))
    claim["cells"] = [claim["cells"][0], claim["cells"][-1]]
    model = turbine_data(turbine, ())
    return certificate_document(
        model=model, gains=published_law_data(law), claims=[claim], provenance={}
    )


def _write(folder: Path, document: Document) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / CERTIFICATE).write_text(json.dumps(document), encoding="utf-8")
    (folder / GAINS).write_text(json.dumps({"law": document["gains"]}), encoding="utf-8")
    if "model_file" in document["model"]:
        for file in model_files("nrel5mw"):
            shutil.copy(file, folder / file.name)


def _write_plant(folder: Path, name: str) -> None:
    files = plant_files(name)
    found = design_plant(load_plant(name), files=files)
    if isinstance(found, NoDesign):
        raise SystemExit(f"{name}: {found.reason}")
    _write(folder, found.document)
    for file in files:
        shutil.copy(file, folder / file.name)

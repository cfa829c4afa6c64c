"""Static output feedback: gains on the measured states alone, u = u* - sum_i h_i F_i (y - y*).

The law is one of all states whose gains on the others are zero: K_i = F_i C.  Loop, claims, gain
file and exports are those of a law of all states, and the certificate shows the zeros.  Rules have
gains of their own only if every premise is computed from what is measured.

No convex form of the question is known.  The gains are the best that a local search from several
starts finds (``takagi.lmi.structured_pdc``), which knows no limits of inputs and no region of
poles; the claims about these decide.

    hinf asked for                 the energy gain
    no decay rate, all ranges      the cost, states and inputs weighed by their ranges
    else                           the largest decay rate

The gains are bounded by ``gain_bound``, or by twice the norm of gains of all states.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.design.plant.norm_wish import NormWish
    from takagi.lmi import Design
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

# Random gains from which the energy gain is minimised as well.
STARTS = 10
# Bound on the gains where none is given, in the norm of gains of all states.
LARGER = 2.0


def plant_of_law(plant: Plant, settings: PlantSettings) -> Plant:
    """Return the plant as the law sees it: one with a static law needs no observer."""
    return replace(plant, measured=None) if settings.feedback else plant


def require_states(plant: Plant, settings: PlantSettings) -> None:
    """Raise ModelError unless the law has states alone, and searches that it can have."""
    states = tuple(v.name for v in plant.states)
    for name in settings.feedback:
        if name not in states:
            raise ModelError(
                f"controller static: {name} is measured and is no state; name states in measured ("
                f"{', '.join(states)}), write the plant with {name} as a state, or leave "
                "controller out for a law with an observer"
            )
    if settings.objective in ("h2", "peak", "effort"):
        raise ModelError(
            f"objective {settings.objective}: gains of a static law are sought for hinf, for decay "
            "or for the cost by the ranges; choose one of them, or leave controller out"
        )


def measured_states(plant: Plant, settings: PlantSettings) -> list[int]:
    """Return the places of the states that the law has."""
    return [k for k, v in enumerate(plant.states) if v.name in settings.feedback]


def static_gains(
    plant: Plant,
    model: TSModel,
    settings: PlantSettings,
    wish: NormWish | None,
    *,
    relaxation: str,
    box: Floats,
    input_limit: Floats | None,
    unstructured: Design,
) -> tuple[Design, tuple[str, ...]]:
    """Return the best gains that were found, as a design, and notes.

    Parameters
    ----------
    unstructured : gains of all states with the same wishes, for the size that is natural.
    """
    from takagi.lmi import structured_pdc

    rows = measured_states(plant, settings)
    names = ", ".join(plant.states[k].name for k in rows)
    options: dict[str, Any] = {"output": np.eye(len(plant.states))[rows]}
    rate, ranged = settings.decay_rate, bool(np.isfinite(box).all())
    if not unstructured.found:
        return unstructured, (f"without gains of all states there are none of {names}",)
    natural = float(np.linalg.norm(np.asarray(unstructured.gains), 2, axis=(1, 2)).max())
    options["gain_bound"] = settings.gain_bound or float(f"{LARGER * natural:.3g}")
    subject: Any = model
    if wish is not None:
        subject = wish.plant(model, None)
        # Of one rule the descent is the whole search; of several it is a start more.
        options |= {"objective": "hinf", "starts": STARTS if len(model.A) == 1 else 0}
    elif rate is None and settings.objective is None and ranged and input_limit is not None:
        weights = {"Q": np.diag(box**-2), "R": np.diag(input_limit**-2), "deviations": box}
        options |= {"objective": "cost", **weights}
    else:
        options["objective"] = "decay_rate"
    result = structured_pdc(subject, relaxation=relaxation, **options)
    aim = "energy gain" if wish is not None else options["objective"].replace("_", " ")
    note = f"static output feedback of {names}, by a local search for the best {aim}"
    slow = aim == "decay rate" and isinstance(rate, float | int) and result.value < rate
    found = replace(
        unstructured,
        gains=result.gains,
        P=result.P,
        decay_rate=result.value if aim == "decay rate" else 0.0,
        relaxation=result.relaxation,
        answer=result.answer,
    )
    if slow:
        note += f"; it is {result.value:.4g} 1/s, with a norm of at most {options['gain_bound']:g}"
    outside = [name for name in ("initial", "damping", "fastest") if getattr(settings, name)]
    notes = [note]
    if outside:
        notes.append(
            f"{' and '.join(outside)} beside controller static: the search does not know them, and "
            "the claims about the gains decide; where one is not proved, try a smaller gain_bound, "
            "or leave controller out"
        )
    return found, tuple(notes)

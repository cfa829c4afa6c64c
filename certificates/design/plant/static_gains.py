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

from takagi.certificates.design.plant.gain_task import FoundGains, GainTask
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.design.plant.norm_wish import NormWish
    from takagi.lmi import Design
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant

# Random gains from which the energy gain is minimised as well.
STARTS = 10
# Bound on the gains where none is given, in the norm of gains of all states.
LARGER = 2.0


def plant_of_law(plant: Plant, settings: PlantSettings) -> Plant:
    """Return the plant as the law sees it.

    One with a static law needs no observer, one with a controller has the controller's states.

    Raises
    ------
    ModelError : as ``with_integrators``.
    """
    if not settings.feedback or plant.integrators:
        return plant
    return with_integrators(replace(plant, measured=None), settings.order)


def with_integrators(plant: Plant, order: int) -> Plant:
    """Return the plant with x_c' = v beside it, in discrete time x_c(t + T) = v; v are inputs.

    Raises
    ------
    ModelError : more of them than states, or a name of theirs is taken.
    """
    import sympy as sp

    from takagi.models.plant.plant import Variable

    if order > len(plant.states):
        raise ModelError(
            f"controller order={order}: plant {plant.name!r} has {len(plant.states)} states, and "
            "more are of no use to a controller; ask for at most so many"
        )
    names = [f"controller_{k + 1}" for k in range(order)]
    rate_unit = "1/s" if plant.sample_time is None else "-"
    words = "state of the controller itself, no signal of the plant"
    states = [Variable(sp.Symbol(name, real=True), "-", description=words) for name in names]
    rates = [
        Variable(sp.Symbol(f"{name}_rate", real=True), rate_unit, description=f"moves {name}")
        for name in names
    ]
    taken = {v.name for v in plant.variables} | {str(s) for s in (*plant.values, *plant.premises)}
    if clashes := sorted(taken & {v.name for v in (*states, *rates)}):
        raise ModelError(
            f"controller order={order}: {', '.join(clashes)} is a name of the controller, and one "
            f"of plant {plant.name!r}; rename it there"
        )
    return replace(
        plant,
        equations=(*plant.equations, *(v.symbol for v in rates)),
        states=(*plant.states, *states),
        inputs=(*plant.inputs, *rates),
        mass=None if plant.mass is None else sp.diag(plant.mass, sp.eye(order)),
        integrators=tuple((x.name, v.name) for x, v in zip(states, rates, strict=True)),
    )


def require_states(plant: Plant, settings: PlantSettings) -> None:
    """Raise ModelError unless the law has states alone, and searches that it can have."""
    states = tuple(v.name for v in plant.states)
    for name in settings.feedback:
        if name not in states:
            raise ModelError(
                f"controller: {name} is measured and is no state; name states in measured ("
                f"{', '.join(states)}), write the plant with {name} as a state, or leave "
                "controller out for a law with an observer"
            )
    if settings.objective in ("h2", "peak", "effort"):
        raise ModelError(
            f"objective {settings.objective}: gains of a static law are sought for hinf, for decay "
            "or for the cost by the ranges; choose one of them, or leave controller out"
        )
    if plant.integrators and settings.gain_bound is not None:
        raise ModelError(
            "gain_bound beside a controller of a given order: the sizes of its gains depend on the "
            "units of its states, which are free; bound the inputs by input_limit instead"
        )
    if plant.integrators and (settings.objective == "decay" or settings.decay_rate == "max"):
        raise ModelError(
            "the largest decay rate is not sought for a controller of a given order; give a rate "
            "in numbers, such as --decay-rate 2, and raise it as long as it is proved"
        )


def measured_states(plant: Plant, settings: PlantSettings) -> list[int]:
    """Return the places of the states that the law has: those measured, and its own."""
    known = {*settings.feedback, *(state for state, _ in plant.integrators)}
    return [k for k, v in enumerate(plant.states) if v.name in known]


def static_gains(
    task: GainTask, wish: NormWish | None, *, relaxation: str, unstructured: Design
) -> FoundGains:
    """Return the best gains that were found.

    ``unstructured`` : gains of all states with the same wishes, for the size that is natural.
    """
    from takagi.lmi import structured_pdc

    plant, settings, box, input_limit = task.plant, task.settings, task.box, task.input_limit
    rows = measured_states(plant, settings)
    names = ", ".join(plant.states[k].name for k in rows)
    if not unstructured.found:
        return FoundGains(unstructured, (f"without gains of all states there are none of {names}",))
    natural = float(np.linalg.norm(np.asarray(unstructured.gains), 2, axis=(1, 2)).max())
    options: dict[str, Any] = {
        "output": np.eye(len(plant.states))[rows],
        "gain_bound": settings.gain_bound or float(f"{LARGER * natural:.3g}"),
        "objective": "decay_rate",
    }
    subject: Any = task.model
    costs = settings.decay_rate is None and settings.objective is None and np.isfinite(box).all()
    if wish is not None:
        subject = wish.plant(task.model, None)
        # Of one rule the descent is the whole search; of several it is a start more.
        options |= {"objective": "hinf", "starts": STARTS if len(task.model.A) == 1 else 0}
    elif costs and input_limit is not None:
        weights = {"Q": np.diag(box**-2), "R": np.diag(input_limit**-2), "deviations": box}
        options |= {"objective": "cost", **weights}
    result = structured_pdc(subject, relaxation=relaxation, **options)
    aim = "energy gain" if wish is not None else options["objective"].replace("_", " ")
    note = f"static output feedback of {names}, by a local search for the best {aim}"
    if aim == "decay rate" and task.rate is not None and result.value < task.rate:
        note += f"; it is {result.value:.4g} 1/s, with a norm of at most {options['gain_bound']:g}"
    design = replace(
        unstructured,
        gains=result.gains,
        P=result.P,
        decay_rate=result.value if aim == "decay rate" else 0.0,
        relaxation=result.relaxation,
        answer=result.answer,
    )
    return FoundGains(design, (note, *beyond_search(settings)))


def beyond_search(settings: PlantSettings) -> tuple[str, ...]:
    """Return a note about the wishes that were made and that the search ignores."""
    outside = [name for name in ("initial", "damping", "fastest") if getattr(settings, name)]
    if not outside:
        return ()
    law = f"order={settings.order}" if settings.order else "static"
    smaller = "" if settings.order else "try a smaller gain_bound, or "
    return (
        f"{' and '.join(outside)} beside controller {law}: the search does not know them, and the "
        f"claims about the gains decide; where one is not proved, {smaller}leave controller out",
    )

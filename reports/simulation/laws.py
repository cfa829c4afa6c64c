"""The laws to choose from, all made from one design and simulated with its observer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.laws.protocol import Law
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.closed_loop import Observer
from takagi.models.simulation.speed_filter import SpeedFilter
from takagi.models.turbine.data import Turbine

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.certificates.design.turbine.settings import DesignSettings

# The law's name, and what a reader of its numbers should know.
LAW_NAMES: Mapping[str, str] = MappingProxyType(
    {
        "coherent": "one effort, shared between torque and pitch; constant torque above rated wind",
        "paper": (
            "the published law with its one integrator for both regions: near rated wind it can "
            "rest only with too much pitch and too little torque, and the blending adds pitch gain "
            "that its regional gains do not know of, so that pitch oscillates on this plant "
            "(docs/laws.md, how the published law was read)"
        ),
        "paper-two-integrators": (
            "the published law with an integrator for each region: above rated wind it rests at a "
            "small overspeed that both carry, and the pitch gain that the blending adds excites "
            "the tower, which its design does not know (docs/laws.md)"
        ),
        "baseline": (
            "the reference's own controller: K omega^2 torque and scheduled PI pitch, constant "
            "power above rated wind; it uses no wind estimate"
        ),
    }
)
DEFAULT_LAWS = ("coherent", "paper", "baseline")

Tell = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class ChosenLaws:
    """Laws by name, and the observer in their loops (None where no law uses an estimate).

    Attributes
    ----------
    speed_filters : law's name -> what is done to the measured speed before the law reads it; a law
        that is not named has nothing of the kind outside itself.
    """

    laws: Mapping[str, Law]
    observer: Observer | None
    speed_filters: Mapping[str, SpeedFilter] = field(default_factory=dict)


def chosen_laws(
    turbine: Turbine,
    names: Sequence[str],
    *,
    settings: DesignSettings | None = None,
    files: Sequence[Path] = (),
    tell: Tell | None = None,
) -> ChosenLaws:
    """Return the named laws, in the order given, a name given twice once.

    Parameters
    ----------
    names : from ``LAW_NAMES``.
    settings : of the design, whose law is the coherent one; None takes the defaults with gains in
        two steps, which take seconds.
    files, tell : see ``design_turbine``.

    Raises
    ------
    ModelError : no or an unknown name, or a design that cannot be made.
    """
    asked_for = require_law_names(names)
    if asked_for == ("baseline",):
        return ChosenLaws({"baseline": BaselineLaw(turbine)}, None)
    # Imported here: the reference's own controller needs no solver.
    from takagi.certificates.design.turbine.design import design_turbine
    from takagi.certificates.design.turbine.scale import default_settings

    if settings is None:
        settings = replace(default_settings(turbine), synthesis="two-step")
    asked = replace(settings, law="coherent")
    design = design_turbine(turbine, asked, files=files, tell=tell)
    laws = {name: _law(name, design) for name in asked_for}
    filters = {"coherent": design.speed_filter} if design.speed_filter else {}
    return ChosenLaws(laws, design.observer.observer, filters)


def require_law_names(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names without repetitions; ModelError for none or an unknown one."""
    if not names:
        raise ModelError(f"no law was given; choose from {', '.join(LAW_NAMES)}")
    for name in names:
        if name not in LAW_NAMES:
            raise ModelError(
                f"law {name!r} is not known{did_you_mean(name, LAW_NAMES)}; choose from "
                f"{', '.join(LAW_NAMES)}"
            )
    return tuple(dict.fromkeys(names))


def _law(name: str, design: TurbineDesign) -> Law:
    if name == "coherent":
        return design.law
    if name == "baseline":
        return BaselineLaw(design.turbine)
    from takagi.certificates.design.turbine.published_law import designed_law

    # The emitted law: what is certified and what is simulated read the same gains.
    asked = replace(design.settings, law=name)
    return designed_law(
        design.turbine, asked, (design.partial_load, design.full_load, design.regional)
    )

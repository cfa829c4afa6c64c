"""docs/pendulum.md: the pendulum derived step by step, from what the tool itself returns.

Gains are written here, not asked of a solver: its last digits differ from machine to machine.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache

import numpy as np
from numpy.typing import NDArray

from catalogue.github import github
from catalogue.pendulum_bounds import bounds_table, table
from takagi.certificates.claims.certification import Certificate, certify
from takagi.models import TSModel, load_model, sector_model
from takagi.models.equations.derivation_step import Step
from takagi.models.plant.plant import Plant
from takagi.reports.figures.plant.weights import premise_curves, weights_figure
from takagi.reports.figures.style import figure_to_svg
from takagi.reports.page.mathml import readable
from takagi.reports.sections.plant.plant import (
    derivation_steps,
    equations_latex,
    parameter_rows,
    variable_rows,
)

# What the kinds of claims on this page say.
CLAIMS = {
    "sector-embedding": "`sector-embedding`, on the box the plant is the blend of these vertices.",
    "decay": "`decay`, $V = x^\\top P x$ falls as $e^{-2 \\alpha t}$ along every blend.",
    "no-common-decay": "`no-common-decay`, no $P$ does so for all blends at once.",
}

FIGURES = {
    "cart_pole_2rules": "pendulum-two-rules.svg",
    "cart_pole": "pendulum-sixteen-rules.svg",
}
# Both poles of each rule at -2 1/s: k = (a + 4, 4) / b, rounded to a tenth.
TWO = [[[-120.7, -22.7]], [[-2551.6, -764.0]]]
# As they were found by `takagi design cart_pole`, rounded to tens.
SIXTEEN = [
    [-3750, -1000], [-2990, -800], [-3800, -980], [-2950, -780],
    [-4140, -990], [-2960, -770], [-4160, -980], [-2950, -760],
    [-3670, -960], [-3530, -1010], [-3720, -950], [-3150, -870],
    [-3950, -980], [-2950, -780], [-4070, -980], [-2910, -750],
]  # fmt: skip
HELD, TOO_MUCH, SIXTEEN_RATE = 1.0, 1.5, 2.0
SHOWN_VERTICES = (1, 16)

# Steps that the page leaves out: the file shows the plant, the bounds give the rules.
UNSHOWN = ("Plant.", "Rules and their corners.")
# Of the second model: they are made as those of the first.
AS_BEFORE = ("Weights of the premises.",)

HEAD = r"""# The pendulum, step by step

For those who want to see every step from an equation to a proof. An inverted pendulum on a cart
becomes a Takagi-Sugeno model twice: with the textbook's two rules, which approximate it, and with
sixteen rules, which are equal to it. In both a decay rate is proved. `make docs` typesets all
formulas and numbers from what takagi returns; coefficients of more than nine digits are shown with
six.
"""

TWO_WORDS = r"""## Two rules

The plant `cart_pole_2rules` blends two local models of the pendulum, at 0 and at 88 degrees, by
the angle. It is an approximation, **not** the pendulum, and every proof about it holds for the
approximation alone. `sector_model(plant)` gives:
"""

BETWEEN = r"""The textbook places both poles of each rule at $-2$ 1/s. The law $u = -\sum_i h_i K_i
x$ has the gains

"""

SIXTEEN_WORDS = r"""## Sixteen rules

The plant `cart_pole` is the pendulum itself (without the cart's position). Its file has the
equations

"""

SIXTEEN_AFTER = r"""### How tight the bounds are

A bound holds for every point of the box. It comes from interval arithmetic with outward rounding,
and the checker computes it again. So it is slightly wider than the range of the premise, here
found by a search:

"""


@cache
def page() -> str:
    """Return the page in Markdown."""
    parts = [HEAD, *_two_rules(), *_sixteen_rules(), *_next()]
    return github("\n".join(parts))


def figures() -> dict[str, str]:
    """Return file name in docs/figures -> SVG of the premises' weights."""
    found = {}
    for name, file in FIGURES.items():
        figure = weights_figure(premise_curves(_model(name)))
        found[file] = figure_to_svg(figure, name=name.replace("_", "-")) + "\n"
    return found


@cache
def certificates() -> Mapping[str, Certificate]:
    """Return what is certified on the page: "two", "too much", "sixteen"."""
    two, sixteen = _model("cart_pole_2rules"), _model("cart_pole")
    return {
        "two": certify(two, np.array(TWO), decay_rate=HELD),
        "too much": certify(two, np.array(TWO), decay_rate=TOO_MUCH),
        "sixteen": certify(sixteen, _sixteen_gains(), decay_rate=SIXTEEN_RATE),
    }


def _two_rules() -> list[str]:
    plant, model = _plant("cart_pole_2rules"), _model("cart_pole_2rules")
    steps, vertices = derivation_steps(model)
    held, not_held = certificates()["two"], certificates()["too much"]
    return [
        TWO_WORDS,
        *_steps((*steps, *vertices)),
        f"Source: {plant.source} (recalled).\n",
        _figure("cart_pole_2rules", "weights of the two rules over the angle"),
        BETWEEN + _display(_gain_matrices(TWO)),
        f"`certify(model, gains, decay_rate={HELD:g})` returns **{held.verdict.name}**:\n",
        _claims(held),
        f"At {TOO_MUCH:g} 1/s no quadratic function common to all blends exists, which is proved "
        f"too: `decay_rate={TOO_MUCH:g}` returns **{not_held.verdict.name}**.\n",
    ]


def _sixteen_rules() -> list[str]:
    plant, model = _plant("cart_pole"), _model("cart_pole")
    steps, vertices = derivation_steps(model)
    shown = [vertices[k - 1] for k in SHOWN_VERTICES]
    found = certificates()["sixteen"]
    return [
        SIXTEEN_WORDS + _given(plant),
        "Its `[premises]` fix what is to become a premise: "
        + ", ".join(f"`{s}`" for s in map(str, plant.premises))
        + ". Without them takagi chooses by itself, and gives 4 rules.\n",
        *_steps(step for step in steps if step.title not in AS_BEFORE),
        "The weights are made as above. The first and the last of the sixteen vertices:\n",
        *_steps(shown),
        _figure("cart_pole", "weights of the four premises over angle and rate"),
        SIXTEEN_AFTER + bounds_table(model),
        "### Gains and proof\n",
        "`takagi design cart_pole --out build/cart_pole` finds a gain for each rule. For such "
        f"gains, from {_gains(0)} N/rad and from {_gains(1)} N s/rad, rounded to tens, "
        f"`certify(model, gains, decay_rate={SIXTEEN_RATE:g})` returns **{found.verdict.name}**:\n",
        _claims(found),
        "The first claim makes the second one a claim about the pendulum. The checker takes the "
        "equations from the certificate, encloses the premises over the box, and rebuilds the "
        "vertices exactly.\n",
    ]


def _next() -> list[str]:
    return [
        "The report of the design has these steps, the motions of the plant and the margins of its "
        "linear loops. Next: [a plant of your own](plants.md), and [what a PROVED certificate "
        "means](certificate.md).\n",
    ]


def _given(plant: Plant) -> str:
    lines = [_display(line) for line in map(readable, equations_latex(plant))]
    variables = [(n, k, u, f"{lo} to {hi}" if lo != "any" else "any", m)
                 for n, k, u, lo, hi, _, m in variable_rows(plant)]  # fmt: skip
    return "\n".join(
        [
            *lines,
            "with\n",
            table(("symbol", "value", "unit", "source"), parameter_rows(plant)),
            table(("variable", "kind", "unit", "box", "meaning"), variables),
            f"Source: {plant.source} (recalled).\n",
        ]
    )


def _steps(steps: Iterable[Step]) -> list[str]:
    return [
        f"**{step.title}**\n\n{_display(readable(step.latex))}"
        for step in steps
        if step.title not in UNSHOWN
    ]


def _display(latex: str) -> str:
    return f"```math\n{latex}\n```\n"


def _gain_matrices(gains: list[list[list[float]]]) -> str:
    parts = [
        rf"K_{{{i}}} = \begin{{pmatrix}}{' & '.join(f'{x:g}' for x in K[0])}\end{{pmatrix}}"
        for i, K in enumerate(gains, 1)
    ]
    return r",\quad ".join(parts)


def _gains(state: int) -> str:
    """Return the least and the greatest size of the sixteen gains of a state."""
    sizes = [K[state] for K in SIXTEEN]
    return f"{max(sizes)} to {min(sizes)}"


def _claims(found: Certificate) -> str:
    pairs = zip(found.document["claims"], found.checked.claims, strict=True)
    lines = [f"- {c.verdict.name}: {CLAIMS[claim['kind']]}" for claim, c in pairs]
    return "\n".join(lines) + "\n"


def _figure(name: str, words: str) -> str:
    return f"![{words.capitalize()}](figures/{FIGURES[name]})\n"


def _sixteen_gains() -> NDArray[np.float64]:
    return np.array(SIXTEEN, dtype=np.float64)[:, None, :]


@cache
def _plant(name: str) -> Plant:
    found = load_model(name)
    assert isinstance(found, Plant)
    return found


@cache
def _model(name: str) -> TSModel:
    return sector_model(_plant(name))

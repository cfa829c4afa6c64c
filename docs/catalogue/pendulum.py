"""docs/pendulum.md: the pendulum derived step by step, from what the tool itself returns.

Gains are written here, not asked of a solver: its last digits differ from machine to machine.
"""

from __future__ import annotations

from collections.abc import Mapping
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

HEAD = r"""# The pendulum, step by step

For those who want to see every step: an inverted pendulum on a cart, from its equation to a proved
controller, in two versions. The textbook's two rules approximate the pendulum, sixteen rules are
the pendulum. All formulas and numbers are typeset from what takagi returns, by `make docs`.

Coefficients of more than nine digits are shown with six; model and certificate have all of them.
"""

TWO_WORDS = r"""## Two rules

The plant `cart_pole_2rules` is itself a fuzzy model: two local models of the pendulum, one at 0 and
one at 88 degrees, blended by the angle. It is an approximation, **not** the pendulum, and every
proof about it holds for this approximation alone. Its file says

"""

BETWEEN = r"""On the box this model equals the plant of the file. But that plant only approximates
a pendulum; the model with sixteen rules below does not.

### Gains and proof

The textbook places both poles of each rule at $-2$ 1/s. With $A_i$, $B_i$ as above,
$u = -\sum_i h_i K_i x$ with the gains

"""

SIXTEEN_WORDS = r"""## Sixteen rules

The plant `cart_pole` is the pendulum itself (angle and rate; the cart's own place is left out). Its
file says

"""

SIXTEEN_AFTER = r"""### How tight the bounds are

Each bound holds for every point of the box, not for samples: it comes from interval arithmetic
with outward rounding, cell by cell, and the certificate's checker computes it again. A proved bound
is slightly wider than the true range of the premise. The table compares it with the extreme values
that a search in the box finds:

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
        TWO_WORDS + _given(plant),
        "### Derivation\n",
        "`sector_model(plant)` gives:\n",
        *map(_step, (*steps, *vertices)),
        _figure("cart_pole_2rules", "weights of the two rules over the angle"),
        BETWEEN + _display(_gain_matrices(TWO)),
        f"are certified: `certify(model, gains, decay_rate={HELD:g})` returns "
        f"**{held.verdict.name}**.\n",
        _claims(held),
        f"The decay rate has a limit. At {TOO_MUCH:g} 1/s no quadratic function common to all "
        f"blends exists, which is proved too: `decay_rate={TOO_MUCH:g}` returns "
        f"**{not_held.verdict.name}**.\n",
        _claims(not_held),
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
        + ". Without them takagi chooses by itself (`premises={}` gives 4 rules).\n",
        "### Derivation\n",
        *map(_step, steps),
        "Two of the sixteen vertices, the first and the last:\n",
        *map(_step, shown),
        _figure("cart_pole", "weights of the four premises over angle and rate"),
        SIXTEEN_AFTER + bounds_table(model),
        "### Gains and proof\n",
        "`takagi design cart_pole --out build/cart_pole` finds gains for all rules. These are such "
        "gains, rounded to tens, in N/rad and N s/rad:\n",
        _gain_table(model),
        f"`certify(model, gains, decay_rate={SIXTEEN_RATE:g})` returns **{found.verdict.name}**:\n",
        _claims(found),
        "The first claim is what makes the second one about the pendulum: the checker takes the "
        "equations of the plant and the premises from the certificate, encloses the premises over "
        "the box again, and rebuilds the vertices exactly.\n",
    ]


def _next() -> list[str]:
    return [
        "## The same in the shell\n",
        "```sh\n"
        "takagi design cart_pole --out build/cart_pole\n"
        "takagi check build/cart_pole/certificate.json --gains build/cart_pole/gains.json\n"
        "```\n",
        "The folder has a report with these steps, the motions of the nonlinear plant and the "
        "margins of its linear loops. [Writing a plant file](plants.md) shows how to describe a "
        "plant of your own, [what a PROVED certificate means](certificate.md) what is and what is "
        "not claimed.\n",
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


def _step(step: Step) -> str:
    return f"**{step.title}**\n\n{_display(readable(step.latex))}"


def _display(latex: str) -> str:
    return f"```math\n{latex}\n```\n"


def _gain_matrices(gains: list[list[list[float]]]) -> str:
    parts = [
        rf"K_{{{i}}} = \begin{{pmatrix}}{' & '.join(f'{x:g}' for x in K[0])}\end{{pmatrix}}"
        for i, K in enumerate(gains, 1)
    ]
    return r",\quad ".join(parts)


def _gain_table(model: TSModel) -> str:
    names = [premise.name for premise in model.premises]
    words = ("lower", "upper")
    rows = [
        (str(i), *(words[c] for c in rule), *(f"{x:g}" for x in K))
        for i, (rule, K) in enumerate(zip(model.rules, SIXTEEN, strict=True), 1)
    ]
    return table(("rule", *names, "by angle", "by rate"), rows)


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

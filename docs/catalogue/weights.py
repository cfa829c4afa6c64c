"""docs/weights.md: every kind of claim against every kind of weights, theorem or refusal."""

from __future__ import annotations

from types import MappingProxyType

COLUMNS = ("shared", "own", "products", "tables", "secants", "sampled")

PROVED, REFUSED = "theorem", "refused"
THEOREM = (PROVED,) * 5
PLANT = "refused: no plant"
OTHER = ("refused: another model",) * 5
# Kind of claim -> what both checkers say of it for the first five kinds of weights.
CELLS = MappingProxyType(
    {
        "decay": THEOREM,
        "transient": THEOREM,
        "region": THEOREM,
        "gain-rounding": THEOREM,
        "box-enlargement": THEOREM,
        "no-common-decay": ("disproof", "open (9)", "disproof", "disproof", "open (9)"),
        "invariant-ellipsoid": THEOREM,
        "input-limits": THEOREM,
        "input-limits, rates": (PROVED, "refused (1)", PROVED, PROVED, "refused (1)"),
        "l2-gain": THEOREM,
        "l2-gain, output by rule": (PROVED, PROVED, PROVED, PROVED, "refused (2)"),
        "fuzzy-l2-gain": (PROVED, "refused (4)", PROVED, PROVED, "refused (5)"),
        "h2-norm": ("theorem (10)", "theorem (3, 10)", *("theorem (10)",) * 3),
        "peak": THEOREM,
        "exit-probability": ("theorem (10)", "theorem (3, 10)", *("theorem (10)",) * 3),
        "sampled-loop": THEOREM,
        "fuzzy-decay": (PROVED, "refused (4)", PROVED, PROVED, "refused (5)"),
        "observer": ("theorem (6)", "theorem (6)", PROVED, PROVED, "refused (7)"),
        "observed-feedback": ("theorem (6)", "refused (4)", PROVED, PROVED, "refused (7)"),
        "observed-loop": ("theorem (6)", "refused (4)", PROVED, PROVED, "refused (7)"),
        "observed-loop, by estimate": (
            *("refused (11)",) * 2,
            PROVED,
            "refused (12)",
            "refused (7)",
        ),
        "slope-embedding": (PLANT, PLANT, PROVED, "refused (12)", PROVED),
        "sector-embedding": (PLANT, PLANT, PROVED, PROVED, "refused: its form"),
        "secant-embedding": (PLANT, PLANT, "refused: its form", "refused: its form", PROVED),
        "tracking": (PLANT, PLANT, "refused: its form", "refused: its form", "refused (13)"),
        "effort-blend": (PLANT, PLANT, "theorem (8)", "theorem (8)", "refused (8)"),
        "quadratic-decay": THEOREM,
        "no-common-quadratic": ("disproof",) * 5,
        "coherent-loop": OTHER,
        "paper-loop": OTHER,
        "wind-rate": OTHER,
        "actuator-rates": OTHER,
        "running-loop": OTHER,
        "running-rate": OTHER,
        "schedule-rate": OTHER,
    }
)

HEAD = """# Claims and weights

A loop is a blend of vertices. Which claims are theorems depends on the kind of its weights. Both
checkers decide as this table says, for a certificate of `certify` and for one that is written by
hand. A test has a certificate for each cell of the table, and simulates the nonlinear plant.

| weights | what they are |
|---|---|
| shared | of a model given by its vertices; the law u = -sum_j h_j K_j x has the same |
| own | of the same model, with a law whose weights are others, or that does not say which |
| products | of a sector model of a plant: products over its premises, which the law evaluates |
| tables | the same, where a premise holds a table |
| secants | of a secant embedding: averages of slopes between rest and the state |
| sampled | of a model with a premise whose bounds rest on samples |

"Sampled" has no column, because it is refused in every row. `certify` refuses such a model. For a
certificate written by hand the checker bounds the premises itself, finds the point that the samples
missed, and leaves `sector-embedding` open.
"""

NOTES = """
The last ten kinds are about a turbine's model, which no certificate of a plant has;
`quadratic-decay` and `no-common-quadratic` hold their own matrices.

Consider a law with different gains whose weights depend on its own input. It would need its command
before the command is computed. Its gains are proved for weights of their own. (An example is
x' = x + (5 - u^2) u with gains 0.3 at u = 0 and 1.2 at u^2 = 4. With the weights of the model every
blend decays. But the law at run time takes u = 0, because it does not know the command yet, and is
unstable at x = 6.5.)

1. u' contains the rates of the law's weights and those of the plant's. With one gain for all rules,
   and in discrete time, it is a theorem.
2. With one output matrix, or for the plant's own output, it is a theorem. An output that is written
   by rules needs the weights: with the slopes at the present state instead of the averages it is
   another output. (x' = -x - x^3 + w, y = h_2 x: the inequalities hold with a gain of 0.3, but for
   w = 2 the equilibrium is x = 1, where y = 1 is half of w.)
3. The verdict says "for weights that do not depend on the noise at the same instant". (x+ = x/2 +
   u + w with u = 0 or -x, whichever makes x w grow: the mean of x^2 is 3.0, where it is 1.33 else.)
   Where a signal p moves a plant's premises it says "for values of p", not "for weights".
   Where the premises of a plant depend on the noise, the claim is refused in every column.
4. P(h), and the loop through an observer, need gains with the weights of the model, or one gain.
5. V = x'P(h)x would depend on averages that cannot be computed. (x' = -10 x - x^3, P = 2 at slope
   10 and 1 at slope 13, rates up to 22 1/s: the inequalities hold at 1.99 1/s, but with the slopes
   at the present state V does not decrease at x = 1.) If P does not depend on the weights, use
   `decay`.
6. The verdict says "for premises that the observer measures". For a plant the checker proves this:
   every variable that a premise depends on is an input, or is itself an output to which no input is
   added; otherwise the claim is left open. (x' = x + u, y = x + x u: for u = -1 the output is 0.)
7. The observer would need the averages. (x' = -x - x^3 + u, y = x, L = 1, with the slope at the
   measured x: at constant x = 0.9 the error does not decay, but the claim says e^(-4t).) An
   observer for a model whose A, B, C and D are the same in all rules needs no weights, and is a
   theorem.
8. For a plant with `[blending]`. Its share is a signal that changes the matrices. In a secant
   embedding the share would also enter by a slope of its own, so this is refused.
9. Left open, not refused: it is not known which gain of a law with weights of its own is combined
   with which rule, so no loop is excluded. With one gain for all rules it is a disproof.
10. In continuous time, where the matrix by which noise enters differs between rules, the verdict
   says "in Ito's sense". (x1' = -x1 + w, x2' = -x2/5 + tanh(5 x1) w: the mean of x2^2 is at most
   2.52 in Ito's sense, and 7.96 in a simulation with noise of 500 rad/s bandwidth.)
11. Weights at the estimate need the slopes of a plant between any two states (`slope-embedding`),
   and the vertices alone do not determine them. (Rules x' = -x and x' = -2 x, y = x: if the plant
   has the first rule and the estimate the second, e' = x - (2 + L) e, which contains x.)
12. A certificate has no name for the slope of a table.
13. For a plant with `[reference]`, which is a secant embedding with one gain, it is a theorem,
   because it compares two states by slopes and needs no weights.

[Claims](claims.md) and the docstring of each kind have the theorems.
"""


def page() -> str:
    """Return docs/weights.md."""
    columns = COLUMNS[:-1]
    lines = [f"| kind | {' | '.join(columns)} |", "|---" * (len(columns) + 1) + "|"]
    for kind, cells in CELLS.items():
        name, _, rest = kind.partition(", ")
        lines.append(f"| `{name}`{', ' + rest if rest else ''} | {' | '.join(cells)} |")
    return HEAD + "\n" + "\n".join(lines) + "\n" + NOTES

"""The plant's equations in C, and their integration by fixed steps of Runge and Kutta."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from takagi.reports.code.c.expressions import Expressions
from takagi.reports.code.c.sample import assignment_lines
from takagi.reports.code.c.source import constant_text
from takagi.reports.code.c.words import HELPERS, RESERVED, helpers
from takagi.reports.code.fmu.plant_equations import PlantEquations
from takagi.reports.code.formula import names_of
from takagi.reports.code.identifiers import identifiers

OWN = ("m", "x", "rate", "mass", "model", "plant_rate", "plant_hold", "plant_solve", "plant_real")


def plant_source(plant: PlantEquations, places: Mapping[str, str], first: str) -> str:
    """Return the functions ``model_move``, ``model_arrive`` and ``plant_next``.

    Parameters
    ----------
    places : name of a state, disturbance or command -> its place in ``real``, as C.
    first : the place of the first state.
    """
    outside = [*(one.name for one in plant.disturbances), *plant.commands]
    own = [*(one.name for one in plant.constants), *(one.name for one in plant.states)]
    own += [*outside, *(one.name for one in plant.steps)]
    reserved = RESERVED | set(OWN) | {f"plant_{one}" for one in HELPERS}
    names = identifiers(own, reserved, language="C")
    used = {name for formula in plant.formulas() for name in names_of(formula)}
    constants = {one.name: one for one in plant.constants if one.name in used}
    write = Expressions(names, constants, "plant_", "")
    lines = [
        f"const double {names[one.name]} = x[{k}];"
        for k, one in enumerate(plant.states)
        if one.name in used
    ]
    lines += [f"const double {names[o]} = m->real[{places[o]}];" for o in outside if o in used]
    for step in plant.steps:
        lines += assignment_lines(step, "plant", write)
    for k, state in enumerate(plant.states):
        text = write.text(state.rate)
        lines += [*write.taken_before(), f"rate[{k}] = {text};"]
    lines += _mass(plant, write)
    rate = _function("static void plant_rate(const model *m, const double *x, double *rate)", lines)
    hold = _function("static void plant_hold(double *x)", list(_held(plant, write)))
    texts = (constant_text(one, names[one.name], "plant", write) for one in constants.values())
    n = len(plant.states)
    parts = [
        "\n/* The plant. */\ntypedef double plant_real;\n" + f"enum {{ PLANT_STATES = {n} }};\n",
        "".join(texts),
        helpers(write.helpers, "plant_", "double", ""),
        SOLVE if plant.mass is not None else "",
        f"\n/* {'x(t + T)' if plant.discrete else 'dx/dt'} in the order of the states. */",
        rate,
        DISCRETE if plant.discrete else f"{hold}{CONTINUOUS}",
    ]
    return "".join(parts).replace("FIRST", first)


def _mass(plant: PlantEquations, write: Expressions) -> Iterator[str]:
    if plant.mass is None:
        return
    rows = ["{ " + ", ".join(map(write.text, row)) + " }" for row in plant.mass]
    yield from write.taken_before()
    yield "{"
    yield "    double mass[PLANT_STATES][PLANT_STATES] = {"
    yield from (f"        {row}," for row in rows)
    yield "    };"
    yield "    plant_solve(mass, rate);"
    yield "}"


def _held(plant: PlantEquations, write: Expressions) -> Iterator[str]:
    """Yield the lines that hold states within their limits."""
    if not any(one.limits for one in plant.states):
        yield "(void)x;"
    for k, state in enumerate(plant.states):
        if state.limits is not None:
            low, high = map(write.text, state.limits)
            yield f"x[{k}] = x[{k}] < {low} ? {low} : x[{k}] > {high} ? {high} : x[{k}];"


def _function(head: str, lines: list[str]) -> str:
    return f"\n{head}\n{{\n" + "".join(f"    {one}\n" for one in lines) + "}\n"


SOLVE = """
/* mass * rate = the given rate, by elimination with the largest pivot; 0/0 gives no number */
static void plant_solve(double mass[PLANT_STATES][PLANT_STATES], double *rate)
{
    int i;
    int j;
    int k;
    for (k = 0; k < PLANT_STATES; k++) {
        int best = k;
        for (i = k + 1; i < PLANT_STATES; i++) {
            best = fabs(mass[i][k]) > fabs(mass[best][k]) ? i : best;
        }
        for (j = 0; j < PLANT_STATES; j++) {
            const double entry = mass[k][j];
            mass[k][j] = mass[best][j];
            mass[best][j] = entry;
        }
        {
            const double entry = rate[k];
            rate[k] = rate[best];
            rate[best] = entry;
        }
        for (i = k + 1; i < PLANT_STATES; i++) {
            const double share = mass[i][k] / mass[k][k];
            for (j = k; j < PLANT_STATES; j++) {
                mass[i][j] -= share * mass[k][j];
            }
            rate[i] -= share * rate[k];
        }
    }
    for (k = PLANT_STATES - 1; k >= 0; k--) {
        for (j = k + 1; j < PLANT_STATES; j++) {
            rate[k] -= mass[k][j] * rate[j];
        }
        rate[k] /= mass[k][k];
    }
}
"""

CONTINUOUS = """
/* One step of the classical method of Runge and Kutta; commands and disturbances are held. */
static void plant_step(const model *m, double *x, double step)
{
    double k1[PLANT_STATES];
    double k2[PLANT_STATES];
    double k3[PLANT_STATES];
    double k4[PLANT_STATES];
    double at[PLANT_STATES];
    int k;
    plant_rate(m, x, k1);
    for (k = 0; k < PLANT_STATES; k++) {
        at[k] = x[k] + step / 2.0 * k1[k];
    }
    plant_rate(m, at, k2);
    for (k = 0; k < PLANT_STATES; k++) {
        at[k] = x[k] + step / 2.0 * k2[k];
    }
    plant_rate(m, at, k3);
    for (k = 0; k < PLANT_STATES; k++) {
        at[k] = x[k] + step * k3[k];
    }
    plant_rate(m, at, k4);
    for (k = 0; k < PLANT_STATES; k++) {
        x[k] = x[k] + step / 6.0 * (k1[k] + 2.0 * (k2[k] + k3[k]) + k4[k]);
    }
    plant_hold(x);
}

/* At most one sample time. */
static void model_move(model *m, double time)
{
    const double wanted = ceil(time / m->real[AT_integration_step] - 1e-6);
    const long count = wanted > 1.0 ? (long)wanted : 1;
    long k;
    for (k = 0; k < count; k++) {
        plant_step(m, &m->real[FIRST], time / (double)count);
    }
}

static void plant_next(model *m)
{
    (void)m;
}

static void model_arrive(model *m)
{
    (void)m;
}
"""

DISCRETE = """
static void model_move(model *m, double time)
{
    (void)m; /* in discrete time nothing moves between the samples */
    (void)time;
}

/* Where the states will be at the next sample. */
static void plant_next(model *m)
{
    plant_rate(m, &m->real[FIRST], m->next);
    m->waits = 1;
}

static void model_arrive(model *m)
{
    if (m->waits) {
        memcpy(&m->real[FIRST], m->next, sizeof m->next);
        m->waits = 0;
    }
}
"""

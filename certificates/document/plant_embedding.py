"""A plant, its model and its observer, as a certificate states them; the claims that link them.

The certificate has the plant's own equations, parameters and ranges, the premises with their
bounds, and the entries of A, B, ... as text in the premises.  From these the checker
computes the vertices, and proves that the entries give the equations and that the bounds hold.

For a plant with two actuators the model of the certificate is the blended plant, with the share of
the high actuator and the errors of both as signals; the claim ``effort-blend`` ties it to the plant
with its two actuators.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.plant.sector_embedding import plant_loop
from takagi.certificates.document.model_data import as_read, rounded_up
from takagi.models.arrays import Floats
from takagi.models.blending.blending import EFFORT, RATE, SHARE
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.ramps import ramp, ramp_slope

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.blending.blending import Actuator, Blending
    from takagi.models.equations.equilibrium import Ball
    from takagi.models.equations.problem import Problem
    from takagi.models.plant.plant import Variable
    from takagi.models.splines.table_function import TableFunction
    from takagi.models.ts.model import SymbolicForm, TSModel


def is_embedded(model: TSModel) -> bool:
    """Return whether the model contains the plant that it was derived from, on a box."""
    form = None if model.derivation is None else model.derivation.form
    return form is not None and form.problem.domain is None and not model.sampled


def plant_and_claim(
    model: TSModel,
) -> tuple[dict[str, Any] | None, list[dict[str, Any]], tuple[str, ...]]:
    """Return what a certificate says of the model's plant, the claim in front, and notes.

    ``(None, [], ())`` for a model without a plant. A plant that cannot be written is left out too,
    and a note gives the reason.
    """
    if not is_embedded(model):
        return None, [], ()
    try:
        data, claims = plant_data(model), [embedding_claim(model)]
        notes: tuple[str, ...] = ()
        if blend_of(model) is not None:
            # Without evidence: the checker bounds effectiveness by its own search.
            plant = model.name or "the plant"
            name = f"{plant} behind its blend, with both actuators within their limits"
            claims.append({"name": name, "kind": "effort-blend"})
            bumpless, notes = bumpless_claim(model, data)
            claims += bumpless
        return data, claims, notes
    except ModelError as error:
        return None, [], (f"claims about the vertices alone: {error}",)


def law_members(model_data: Mapping[str, Any]) -> dict[str, Any]:
    """Return premises and trim of a law for a model of kind ``plant``; nothing for another kind.

    The premises are those of the embedding, so that the checker can prove that the law has the
    weights of the model.  The trim is the plant's equilibrium, in floats.
    """
    if model_data["kind"] != "plant":
        return {}
    trim = {
        key: [float(_exact(variable["rest"])) for variable in model_data[group]]
        for key, group in (("state", "states"), ("input", "inputs"))
    }
    if "references" in model_data:
        # One gain, because weights of mean slopes are not known to a law.
        return {"trim": trim, "references": model_data["references"]}
    extras = {key: model_data[key] for key in ("blending", "integrators") if key in model_data}
    return {"premises": model_data["embedding"]["premises"], "trim": trim, **extras}


def _exact(value: float | int | str | dict[str, Any]) -> Fraction:
    if isinstance(value, dict):
        return _exact(value["value"])
    if not isinstance(value, str):
        return Fraction(repr(value))
    from takagi.certificates.checker.plant.reading import constant_bracket

    low, high = constant_bracket(value)
    return (low + high) / 2


def embedding_claim(model: TSModel) -> dict[str, Any]:
    """Return the claim that the plant is the blend of the model's vertices on its box.

    It has no evidence: the checker bounds the premises by a search of its own.
    """
    form = None if model.derivation is None else model.derivation.form
    kind = "sector" if form is None else form.kind
    name = "is its Takagi-Sugeno model" if kind == "sector" else "lies in its secants"
    return {"name": f"{model.name or 'the plant'} {name}", "kind": f"{kind}-embedding"}


def plant_data(model: TSModel) -> dict[str, Any]:
    """Return the ``model`` member of kind ``plant`` for a model of ``sector_model``.

    Numbers are written as decimals if they are decimals, else as text, e.g. ``"250/9"``.
    Expressions use the grammar of plant files.

    Raises
    ------
    ModelError : a model that was not derived from symbols, whose bounds hold on a band or rest on
        samples, with premises other than those of its derivation, or with an expression that the
        grammar cannot express.
    """
    form = None if model.derivation is None else model.derivation.form
    if form is None or not is_embedded(model):
        raise ModelError(
            f"model {model.name!r} does not carry a plant on a box with proved bounds; derive it "
            "with sector_model, over a box"
        )
    blending = blend_of(model)
    data = {
        "kind": "plant",
        "name": model.name,
        "source": model.source,
        "sample_time": model.sample_time,
        **_plant(form),
        **({} if blending is None else {"blending": blend_data(blending)}),
        **_states_of_law(form),
        "embedding": _embedding(model, form),
    }
    _check_vertices(model, data)
    return data


# ---------------------------------------------------------------------- the plant


def _plant(form: SymbolicForm) -> dict[str, Any]:
    plant, problem = form.plant, form.problem
    expressions: list[sp.Expr] = [*plant.equations, *(y.expression for y in plant.outputs)]
    data: dict[str, Any] = {}
    deviations = (
        problem.equations.states,
        problem.equations.inputs,
        problem.equations.disturbances,
    )
    groups = (plant.states, plant.inputs, plant.disturbances)
    for key, variables, symbols in zip(
        ("states", "inputs", "disturbances"), groups, deviations, strict=True
    ):
        data[key] = [
            _variable(variable, symbol, problem)
            for variable, symbol in zip(variables, symbols, strict=True)
        ]
    data["parameters"] = {
        p.symbol.name: _ball(problem.balls[p.symbol])
        if p.symbol in problem.balls
        else number_data(p.value)
        for p in plant.parameters
    }
    data["equations"] = _texts(plant.equations)
    data["outputs"] = [
        {"name": y.name, "unit": y.unit, "expression": text}
        for y, text in zip(plant.outputs, _texts(y.expression for y in plant.outputs), strict=True)
    ]
    if plant.mass is not None:
        data["mass"] = [_texts(plant.mass.row(i)) for i in range(plant.mass.rows)]
        expressions += list(plant.mass)
    return data | tables_data([*expressions, *form.factored.premises.values()])


def _variable(variable: Variable, symbol: sp.Symbol, problem: Problem) -> dict[str, Any]:
    equilibrium = problem.rest[variable.symbol]
    data: dict[str, Any] = {"name": variable.name, "unit": variable.unit, "range": None}
    if variable.unknown:
        data["unknown"] = True
    side, ball = problem.box.get(symbol), problem.balls.get(variable.symbol)
    if ball is not None:
        data["rest"] = _ball(ball)
        if side is not None:
            ends = (side.lower + ball.side.lower, side.upper + ball.side.upper)
            data["range"] = [number_data(end) for end in ends]
    elif not equilibrium.is_Rational:
        data["rest"] = text_data(equilibrium)
    else:
        resting = Fraction(int(equilibrium.p), int(equilibrium.q))
        data["rest"] = number_data(resting)
        # The box of the model, which may be less than the plant's ranges.
        if side is not None:
            data["range"] = [number_data(end + resting) for end in (side.lower, side.upper)]
    return data if symbol.name == variable.name else data | {"symbol": symbol.name}


def _ball(ball: Ball) -> dict[str, Any]:
    data = {"value": number_data(ball.middle), "within": number_data(ball.radius)}
    return data if ball.equals is None else data | {"equals": text_data(ball.equals)}


def _states_of_law(form: SymbolicForm) -> dict[str, Any]:
    plant = form.plant
    if plant.integrators:
        pairs = plant.integrators
        return {"integrators": [{"state": state, "rate": rate} for state, rate in pairs]}
    if not plant.references:
        return {}
    import sympy as sp

    rows = {v.name: row for v, row in zip(plant.states, plant.equations, strict=True)}
    listed = [
        {
            "reference": reference.name,
            "integral": reference.integral,
            "follow": text_data(rows[reference.integral] + sp.Symbol(reference.name, real=True)),
        }
        for reference in plant.references
    ]
    return {"references": listed}


# ---------------------------------------------------------------------- premises and entries


def _embedding(model: TSModel, form: SymbolicForm) -> dict[str, Any]:
    factored = form.factored
    names = [premise.name for premise in model.premises]
    if names != [symbol.name for symbol in factored.premises]:
        raise ModelError(
            f"model {model.name!r} has the premises {', '.join(names)}, which are not those that "
            "it was derived with; certify the model as sector_model returns it"
        )
    constants = {
        s: rational_symbol(v) for s, v in factored.constants.items() if s not in factored.numbers
    }
    numbers = [
        {
            "name": symbol.name,
            "expression": text_data(number.expression),
            "lower": number_data(number.lower),
            "upper": number_data(number.upper),
        }
        for symbol, number in factored.numbers.items()
    ]
    premises = [
        {
            "name": premise.name,
            "expression": text_data(expression.xreplace(constants)),
            "lower": number_data(premise.lower),
            "upper": number_data(premise.upper),
            "unit": premise.unit,
        }
        for premise, expression in zip(model.premises, factored.premises.values(), strict=True)
    ]
    matrices = {
        letter: [_texts(matrix.xreplace(constants).row(i)) for i in range(matrix.rows)]
        for letter, matrix in factored.matrices.items()
        if 0 not in matrix.shape
    }
    kind = {} if form.kind == "sector" else {"form": form.kind}
    listed = {"numbers": numbers} if numbers else {}
    return {**kind, "premises": premises, **listed, **matrices}


def _check_vertices(model: TSModel, data: Mapping[str, Any]) -> None:
    """Refuse what the checker cannot read, and a model whose vertices are not those of the data."""
    read = as_read({"model": data}, "model")["model"]
    try:
        loop = plant_loop(read)
    except CertificateError as error:
        raise ModelError(
            f"model {model.name!r}: its plant cannot be written into a certificate: {error}"
        ) from error
    numbers = "numbers" in data["embedding"]
    for letter in ("A", "B", "C", "D", "E"):
        stack, vertices = getattr(loop, letter), getattr(model, letter)
        exact = np.array([[[row / M.below for row in line] for line in M.rows] for M in stack])
        # The model's arrays are floats, and the vertices in the file are exact: equal up to
        # rounding, and up to the bounds of numbers that are no fractions.
        size = 1e-12 * float(np.max(np.abs(vertices), initial=0.0)) if numbers else 1e-300
        if stack and not np.allclose(exact, vertices, rtol=1e-12, atol=size):
            raise ModelError(
                f"model {model.name!r}: the vertices of {letter} are not those of its derivation; "
                "certify the model as sector_model returns it"
            )


def _texts(expressions: Iterable[sp.Expr]) -> list[str]:
    return [text_data(expression) for expression in expressions]


def observer_member(L: Floats, measured: Sequence[str], *, at_estimate: bool) -> dict[str, Any]:
    """Return the member ``observer`` of a law, L (r, n, p), or (1, n, p) for one gain in all rules.

    The weights are those at the estimate, or else the plant's own.
    """
    same = bool((L == L[0]).all())
    return {
        "weights": "estimated" if at_estimate else "measured",
        "measured": list(measured),
        "L": (L[:1] if same else L).tolist(),
    }


def slopes_data(slopes: TSModel) -> dict[str, Any]:
    """Return the member ``slopes`` of a model of kind ``plant``: premises and entries.

    ``slopes`` : the plant's ``secant_model``.

    Raises
    ------
    ModelError : as ``plant_data``.
    """
    embedding = dict(plant_data(slopes)["embedding"])
    del embedding["form"]
    return embedding


def slope_claim(name: str) -> dict[str, Any]:
    """Return the claim that the slopes of the plant lie in those of the certificate."""
    return {"name": f"slopes of {name or 'the plant'}", "kind": "slope-embedding"}


# ---------------------------------------------------------------------- numbers, tables, blends


def number_data(value: Fraction) -> float | int | str:
    """Return the number as a JSON number, or as text if no float prints it exactly."""
    if value.denominator == 1 and abs(value) < 10**15:
        return int(value)
    written = float(value)
    return written if Fraction(repr(written)) == value else str(value)


def rational_symbol(value: Fraction) -> sp.Rational:
    """Return the number as a SymPy number."""
    import sympy as sp

    return sp.Rational(value.numerator, value.denominator)


def text_data(expression: sp.Expr) -> str:
    """Return the expression in the grammar of plant files; its numbers are not shortened."""
    from takagi.models.equations.problem import cleaned

    return str(cleaned([expression], {})[0]).replace("**", "^").replace("Abs(", "abs(")


def tables_data(expressions: Iterable[sp.Expr]) -> dict[str, Any]:
    """Return the splines in the expressions, by name; empty if there are none."""
    from takagi.models.ranges.tape import tables_class

    tables = tables_class()
    if tables is None:
        return {}
    kinds: dict[str, type[TableFunction]] = {}
    for expression in expressions:
        for call in expression.atoms(tables):
            kinds[type(call).title] = type(call)
    return (
        {"tables": {name: _spline(kind) for name, kind in sorted(kinds.items())}} if kinds else {}
    )


def _spline(kind: type[TableFunction]) -> Mapping[str, Any]:
    from takagi.models.splines.spline import Curve

    table = kind.table
    if isinstance(table, Curve):
        knots = [table.knots.tolist()]
    else:
        knots = [table.x_knots.tolist(), table.y_knots.tolist()]
    return {
        "formula": "sum of coefficients times clamped cubic B-splines over the knots",
        "knots": knots,
        "coefficients": table.coefficients.tolist(),
    }


def blend_of(model: TSModel) -> Blending | None:
    """Return the blend of the plant that a model was derived from; None if it has none."""
    from takagi.models.blending.blending import blending_of

    form = None if model.derivation is None else model.derivation.form
    return None if form is None else blending_of(form.plant)


def unknown_premises(model: TSModel) -> list[bool]:
    """Return, for each premise, whether it depends on what a law does not know.

    That is an actuator's error, or an uncertain parameter.
    """
    form = None if model.derivation is None else model.derivation.form
    if form is None:
        return [False] * len(model.premises)
    blending, pushes = blend_of(model), form.problem.equations.disturbances
    unknown = {
        str(symbol)
        for variable, symbol in zip(form.plant.disturbances, pushes, strict=True)
        if variable.unknown
    }
    if blending is not None:
        unknown |= {a.error_name for a in blending.actuators if a.error}
    expressions = form.factored.premises.values()
    return [bool(unknown & {str(s) for s in e.free_symbols}) for e in expressions]


def blend_data(blending: Blending) -> dict[str, Any]:
    """Return the member ``blending`` of a certificate's model and law; numbers in SI."""
    plant = blending.plant
    return {
        "effort": EFFORT,
        "rate": RATE,
        "share": SHARE,
        "unit": blending.effort.unit,
        "overlap": number_data(blending.overlap),
        "low": _actuator(blending.low),
        "high": _actuator(blending.high),
        "equations": [text_data(row) for row in plant.equations],
    }


def bumpless_claim(
    model: TSModel, data: Mapping[str, Any]
) -> tuple[list[dict[str, Any]], tuple[str, ...]]:
    """Return the claim about the hand-over if it is proved, or why there is none.

    ``data`` : the member ``model`` of the certificate.
    """
    from takagi.certificates.checker.plant.bumpless import PlantBumpless

    blending = blend_of(model)
    assert blending is not None
    if blending.rate.range is None:
        return [], ()
    try:
        low, high = (_command_rate(model, blending, actuator) for actuator in blending.actuators)
        name = f"{model.name or 'the plant'}: neither actuator jumps"
        claim = {"name": name, "kind": "bumpless", "low": low, "high": high}
        read = as_read({"model": data, "claims": [claim]})
        why = PlantBumpless.read(read["claims"][0], read, "claims[0]").failure()
    except (ModelError, CertificateError) as error:
        why = str(error)
    return ([], (f"bumpless: {why}",)) if why else ([claim], ())


def _command_rate(model: TSModel, blending: Blending, actuator: Actuator) -> float:
    """Return a bound of the rate of an actuator's command on the box, in short decimals."""
    import sympy as sp

    from takagi.models.ranges.expression_range import expression_range

    form = None if model.derivation is None else model.derivation.form
    assert form is not None
    plant, sign = form.plant, blending.sign(actuator)
    most = max(sign * end for end in (blending.efforts.lower, blending.efforts.upper))
    slope, delivered = sp.Dummy(), sp.Dummy()
    inverse = 1 / blending.effectiveness(actuator)
    rate = slope * blending.rate.symbol * inverse
    for state, row in zip(plant.states, plant.equations, strict=True):
        rate += delivered * sp.diff(inverse, state.symbol) * row.subs(plant.rationals)
    box = plant.box | {
        slope: Interval(Fraction(0), ramp_slope(most, blending.overlap)),
        delivered: Interval(Fraction(0), ramp(most, blending.overlap)),
    }
    sides = {s: box[s] for s in rate.free_symbols if s in box}
    outer = expression_range(rate, sides, tolerance=Fraction(1, 1000)).outer
    return rounded_up(float(max(-outer.lower, outer.upper)), 4)


def _actuator(actuator: Actuator) -> dict[str, Any]:
    side = actuator.variable.range
    return {
        "input": actuator.name,
        "unit": actuator.variable.unit,
        "direction": actuator.direction,
        "effectiveness": text_data(actuator.effectiveness),
        "idle": number_data(actuator.variable.rest),
        "range": None if side is None else [number_data(side.lower), number_data(side.upper)],
        "error": actuator.error_name if actuator.error else None,
    }

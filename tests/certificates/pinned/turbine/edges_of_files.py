"""What the readers of files and of controllers do exactly at their limits."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace as Told
from typing import Any
from unittest.mock import patch

from takagi.certificates import CertificateError, Verdict
from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.controller import plant_program
from takagi.certificates.checker.files import (
    file_blend,
    given_files,
    model_content,
    plant_file,
    table_file,
    turbine_file,
)
from takagi.certificates.checker.files.differences import Difference
from takagi.certificates.checker.files.plant_units import in_si
from takagi.certificates.checker.kernel.reader import Number
from tests.certificates.pinned.turbine.inputs import read
from tests.certificates.pinned.turbine.pairs_and_limits import refused
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction
PATH = Path("model.toml")
NO_REFERENCES: Any = Told(equations=lambda _: {})
ANY: Any = None


def of_words() -> Named:
    """Yield which values are alike, how many differences are told, and which figures are read."""
    values = (1, True, Decimal("1.0"), "1", "one", None)
    for theirs in values:
        for k, ours in enumerate((Number("1"), Number("1.0"), "1", "one", None)):
            yield f"alike {theirs!r} {k}", file_blend._alike(theirs, ours)
    counts = model_content.MOST_TOLD, model_content.MOST_COUNTED
    for count in (counts[0], counts[0] + 1, counts[1] - 1, counts[1], counts[1] + 1):
        found = [Difference(("a", k), Number("1"), Number("2")) for k in range(count)]
        yield f"told {count}", model_content.told(PATH, found)[-240:]
    for path in (("equations", "x"), ("equations", "x", "unit"), ("outputs", "y", "unit"),
                 ("outputs", "unit", "expression"), ("equations", "unit", "x", "y")):  # fmt: skip
        one = Difference(path, "a", "b")
        yield f"of a plant {path}", model_content._of_a_plant(one)
    with (
        patch.object(model_content, "read_toml", lambda *_, **__: {}),
        patch.object(model_content, "_plain", lambda *_: []),
    ):
        yield "no table", said(model_content.model_content, PATH)
    at: Any = Told(error=CertificateError)
    for figure in ("1e100", "1e101", "-1e-101", "NaN", "Infinity"):
        found_ = said(plant_file.Comparison.figure, at, Decimal(figure), "-", "x")
        yield f"figure {figure}", found_ if isinstance(found_, str) else "a number"
    for kinds in (["quadratic-decay"], ["coherent-loop"], ["coherent-loop", "quadratic-decay"]):
        data = {"claims": [{"kind": kind} for kind in kinds]}
        checked: Any = _Checked(Verdict.PROVED, ["one"])
        told = given_files.of_the_files(data, checked)
        yield f"of the files {kinds}", (told.verdict.name, told.messages)
    for unit in ("m/(min h)", "m/(h min)", "1/(t)", "min/h", "m/min", "N/(m s)", "m/()"):
        yield f"unit {unit}", said(in_si, F(1), unit)


@dataclass(frozen=True)
class _Checked:
    """A verdict with its messages."""

    verdict: Verdict
    messages: list[str]


class _Graph(dict[int, Any]):
    """A graph of told nodes, all of them below each."""

    def below(self, _: Any) -> list[int]:
        return list(self)

    def constant(self, value: int) -> int:
        return value


def of_plants() -> Named:
    """Yield what a plant file is told of rows of the mass matrix, of lengths, and of a table."""

    def compared(mass: dict[str, Any], equal: bool = True, **changes: Any) -> Any:
        sections = {"equations": {"x": "0", "y": "0"}, "mass": mass, "outputs": {"z": "0"}}
        plant: dict[str, Any] = {
            "states": [Told(name="x"), Told(name="y")], "graph": _Graph(),
            "mass": [[1, 0], [0, 1]], "outputs": [5],
        }  # fmt: skip
        own = changes.pop("own", (["x", "y"], [3, 4]))
        at: Any = Told(
            plant=Told(**(plant | changes)), names={}, model={"outputs": [{"name": "z"}]},
            blend=Told(equations=lambda *_: own, compare=lambda *_: None),
            section=sections.__getitem__, same_names=lambda *_: None, error=CertificateError,
            algebra=Told(equal=lambda *_: equal), equal=lambda *_: None,
        )  # fmt: skip
        return said(plant_file.Comparison.expressions, at, {}, NO_REFERENCES)

    row = {"x": "1", "y": "0"}
    yield "all given", compared({"x": row, "y": row})
    for name, wrong in (("text", "xy"), ("list", ["x", "y"]), ("nothing", None)):
        yield f"a row is {name}", compared({"x": wrong, "y": row})
    for equal in (True, False):
        yield f"rows left out {equal}", compared({"x": row}, equal)
        yield f"an entry left out {equal}", compared({"x": {"x": "1"}, "y": row}, equal)
    yield "other equations", refused(lambda: compared({"x": row}, own=(["x", "y"], [3])))
    yield "other outputs", refused(lambda: compared({"x": row}, outputs=[5, 6]))
    graph = _Graph({1: Told(op="table", name="lift"), 2: Told(op="add", name="")})
    for tables in ({}, {"lift": 1}):
        at: Any = Told(
            path=PATH, error=CertificateError, algebra=Told(equal=lambda *_: True),
            plant=Told(graph=graph, tables=tables), ranges=Told(prove_continuous=lambda *_: None),
        )  # fmt: skip
        with patch.object(plant_file, "read_expression", lambda *_: 2):
            yield (
                f"tables {sorted(tables)}",
                said(plant_file.Comparison.equal, at, "x", 1, ANY, "e"),
            )


def of_tables() -> Named:
    """Yield which tables are the certificate's: exactly at the tolerance, and of other lengths."""

    def compared(rows: list[list[F]], arguments: int, units: list[str], **told: Any) -> Any:
        down = rows[1:] if arguments == 2 else rows
        axes = [[row[0] for row in down], *([rows[0]] if arguments == 2 else [])]
        knots = [[p[0]] * 4 + p[2:-2] + [p[-1]] * 4 for p in axes]
        table: Any = Told(**({"arguments": arguments, "knots": knots, "exact": lambda *_: F(1),
                              "sides": [(p[0], p[-1]) for p in axes]} | told))  # fmt: skip
        with patch.object(table_file, "_rows", lambda *_, **__: rows):
            return said(table_file.compare_table, PATH, table, units)

    near, line = table_file.NEAR, [[F(k), F(1)] for k in (3, 4, 6, 7, 10, 13)]
    flat = [row[0] for row in line]
    for off in (F(0), near, near + F(1, 10**9)):
        knots = [flat[0]] * 4 + [flat[2] + 10 * off, flat[3]] + [flat[-1]] * 4
        yield f"knots {off}", compared(line, 1, ["-", "-"], knots=[knots])
        yield f"value {off}", compared(line, 1, ["-", "-"], exact=lambda *_, v=1 + off: v)
    knots = [flat[0]] * 4 + flat[2:-2] + [flat[-1]] * 4
    for name, told in (
        ("knots", {"knots": [knots, knots]}),
        ("sides", {"sides": [(F(3), F(13))] * 2}),
    ):
        yield f"more {name}", refused(lambda told=told: compared(line, 1, ["-", "-"], **told))
    across = [F(k) for k in (1, 2, 5, 7, 8, 9)]
    wide = [across, *([F(k), *[F(1, 100)] * 6] for k in (3, 4, 6, 7, 10, 13))]
    for units in (["-", "-", "%"], ["-", "-", "-"]):
        exact = F(1, 10**4) if units[-1] == "%" else F(1, 100)
        yield f"units {units}", compared(wide, 2, units, exact=lambda *_, v=exact: v)
    for cells in (3, 4, 5):
        text = "".join(f"{k}," for k in range(cells - 1)) + "9"
        with (
            patch.object(table_file, "file_content", lambda *_, t=text, **__: t.encode()),
            patch.object(table_file, "MOST_CELLS", 4),
        ):
            yield f"{cells} cells", said(table_file._rows, PATH, corner=False)


def of_turbines() -> Named:
    """Yield which turbine files are the certificate's, exactly at each tolerance."""
    rated, less = F(40000), 1 - turbine_file.RELATIVE
    for held in (less * rated, less * rated - F(1, 10**9), F(1, 2), F(0), F(-1), rated):
        yield f"held {float(held)}", said(turbine_file._derated, held, rated, PATH)
    for unit in ("m", "furlong", None, ["m"]):
        yield f"unit {unit}", said(turbine_file._si, 1, unit, "here")
    model = read("torque")["model"]
    slack = turbine_file.TABLE_TOLERANCE
    file = {"coefficients": {"power": "cp.csv"}}
    axis = Told(breaks=[F(0), F(10)])
    low, high = ONE // 10, ONE // 5
    spline = Told(x=axis, y=axis, bounds=lambda *_: (low, high))
    step = F(1, 10**12)
    for power in (F(2, 5) + slack, F(2, 5) + slack + step, F(1, 5) - slack, F(1, 5) - slack - step):
        with (
            patch.object(turbine_file, "Spline", lambda *_: spline),
            patch.object(turbine_file, "_entries", lambda _, p=power: ([F(1)], {F(2): [p]})),
            patch.object(turbine_file, "_are_not_a_knot", lambda *_: True),
        ):
            found = said(turbine_file._compare_surface, model, file, PATH)
        yield f"power {power}", found if isinstance(found, str) else "the same"
    breaks, far = [F(0), F(2), F(3), F(5)], turbine_file.RELATIVE
    for off in (F(0), far, far + step):
        points = [F(0), F(1), F(2) + off, F(3), F(4), F(5)]
        yield f"knots off {float(off)}", turbine_file._are_not_a_knot(breaks, points)
    for count in (3, 4, 5):
        ends = [F(0), F(5)]
        points = [F(0), *map(F, range(1, count - 1)), F(5)]
        yield f"{count} points", turbine_file._are_not_a_knot(ends, points)
    figures = ("rotor_inertia", "generator_inertia", "gear_ratio", "rated_rotor_speed")
    inertia, generator, gear, speed = (F(model[name]) for name in figures)
    scale = speed * (inertia + gear**2 * generator)
    for limit in ("0.100001", "0.1000010001", "0.099999", "0.0999989999"):
        gains = {"wind": [Number("8")], "effectiveness_limit": [Number(limit)]}
        given = model, gains, [F(8)], [-scale / 10], PATH
        yield f"limit {limit}", said(turbine_file._compare_limit, *given)
    gains = {name: [Number("1"), Number("1")] for name in ("effectiveness_limit",)}
    gains["wind"] = [Number("8"), Number("10")]
    shortfall = turbine_file.WAKE_SHORTFALL
    for beyond in (F(0), F(1, 10**9)):
        most = -scale / (1 - shortfall - beyond)
        given = model, gains, [F(8), F(9), F(10)], [-scale, most, -scale], PATH
        yield f"between {float(beyond)}", said(turbine_file._compare_limit, *given)


def of_programs() -> Named:
    """Yield that states and deviations are pairs, and what a direction of zero would be."""
    variable = {"name": "u", "unit": "-", "range": None}

    def written() -> Any:
        at: Any = Told(names={}, steps=[], sends=[], own=str)
        return at

    states = [{"name": "x", "unit": "-"}, {"name": "y", "unit": "-"}]
    for names in (["a"], ["a", "b"], ["a", "b", "c"]):
        given: Any = (written(), 0, variable, [variable], states, names, [])
        yield f"deviations {len(names)}", refused(plant_program.PlantWriting.command, *given)
    for direction in ("-1", "0", "1"):
        at = written()
        side = {"input": "u", "effectiveness": "1", "unit": "-", "range": None,
                "direction": Number(direction)}  # fmt: skip
        at.blending = {"effort": "U", "unit": "-", "rate": "r", "low": side, "high": side}
        at.keeps, at.model, at.tables = [], {}, lambda formula: formula
        at.read_also = lambda used: None
        plant_program.PlantWriting.actuators(at)
        yield f"direction {direction}", [str(entry) for entry in at.sends]
    with patch.object(plant_program, "_split", lambda _: ("x", "m", "s")):
        given = ({"kind": "model", "state_names": ["x [m]"]}, "states")
        yield "labels of three parts", refused(plant_program.variables_of, *given)


def groups() -> dict[str, Any]:
    """Return the groups of answers by name."""
    return {
        "edges of words": of_words,
        "edges of plants": of_plants,
        "edges of tables": of_tables,
        "edges of turbines": of_turbines,
        "edges of programs": of_programs,
    }

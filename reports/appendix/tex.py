"""LaTeX of the appendix: jinja2 for it, and numbers, units and words as LaTeX."""

from __future__ import annotations

import json
import math
import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from takagi.certificates.checker.kernel.result import Checked, Verdict
from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.models.arrays import Floats
from takagi.models.intervals.interval import exact
from takagi.models.laws.protocol import law_words
from takagi.reports.figures.style import figure_to_pdf
from takagi.reports.kinds_in_words import KINDS_IN_WORDS
from takagi.reports.page.text import at_least, at_most_to

if TYPE_CHECKING:
    from jinja2 import Environment
    from matplotlib.figure import Figure


class Tex(str):
    """Text that is LaTeX already and is not escaped again."""

    __slots__ = ()


NONE = Tex("--")

_SPECIAL = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "&": r"\&",
    "%": r"\%",
    # As text it would come from a font that many distributions have as a bitmap only.
    "$": r"$\mathdollar$",
    "#": r"\#",
    "_": r"\_",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "\n": " ",
    "²": r"\textsuperscript{2}",
    "°": r"$^\circ$",
    "–": "--",
    "−": "$-$",
    "·": r"\textperiodcentered{}",
    "×": r"$\times$",
    "’": "'",
}
_ACCENTS = {"ä": r"\"a", "ö": r"\"o", "ü": r"\"u", "Ä": r"\"A", "Ö": r"\"O", "Ü": r"\"U"}
_ACCENTS |= {"å": r"\aa{}", "Å": r"\AA{}", "é": r"\'e", "è": r"\`e", "ß": r"\ss{}"}
_POWER = re.compile(r"\^(-?\d+)")


def escape(words: object) -> Tex:
    """Return plain words with every character that LaTeX reads as a command written out.

    A character outside ASCII and the tables above loses its accent, or becomes a question mark, so
    that the document compiles with any engine.
    """
    if isinstance(words, Tex):
        return words
    return Tex("".join(_letter(c) for c in str(words)))


def _letter(c: str) -> str:
    command = _SPECIAL.get(c) or _ACCENTS.get(c)
    if command or " " <= c <= "~":
        return command or c
    return unicodedata.normalize("NFKD", c).encode("ascii", "ignore").decode() or "?"


def unit(name: str) -> Tex:
    """Return a unit in upright letters: ``"N m s^2/rad^2"``; empty for a pure number."""
    if name in ("-", ""):
        return Tex("--")
    escaped = escape(name).replace(r"\textasciicircum{}", "^").replace(" ", r"\,")
    return _in_maths(r"\mathrm{" + _POWER.sub(r"^{\1}", escaped) + "}")


def decimal(value: float | int | str | Fraction) -> Tex:
    """Return a number exactly as it is written to the files: its shortest decimal, no exponent.

    Raises
    ------
    ModelError : not a finite number.
    """
    number = exact(value)
    digits = Decimal(number.numerator) / Decimal(number.denominator)
    text = format(digits, "f")
    return _in_maths(text.rstrip("0").rstrip(".") if "." in text else text)


def with_decimals(value: float, decimals: int) -> Tex:
    """Return a number with this many decimals; infinity and NaN as a dash."""
    number = float(value)
    if not math.isfinite(number):
        return Tex(r"\ensuremath{\infty}") if math.isinf(number) else NONE
    text = f"{number:.{decimals}f}"
    return _in_maths(text[1:] if text.startswith("-") and float(text) == 0 else text)


def scientific(value: float, digits: int = 4) -> Tex:
    """Return a number with this many significant digits, with a power of ten far from 1."""
    number = float(value)
    if number == 0 or not math.isfinite(number):
        return with_decimals(number, 0)
    mantissa, power = f"{number:.{digits - 1}e}".split("e")
    if not -4 <= int(power) < 6:
        return _in_maths(rf"{mantissa} \times 10^{{{int(power)}}}")
    text = f"{number:.{digits}g}"
    return _in_maths(f"{float(text):.0f}" if "e" in text else text)


def interval(ends: Sequence[float | Fraction]) -> Tex:
    """Return [low, high], both ends as ``decimal`` writes them."""
    low, high = (decimal(end) for end in ends)
    return _in_maths(rf"[{low},\ {high}]")


def listed(values: Iterable[float | str | Fraction]) -> Tex:
    """Return numbers as ``decimal`` writes them, with commas between."""
    return Tex(",\\ ".join(decimal(value) for value in values))


def range_text(ends: Iterable[float], decimals: int) -> Tex:
    """Return ``low to high`` of some numbers, or one number where both are equal as written."""
    values = [float(v) for v in ends]
    low, high = with_decimals(min(values), decimals), with_decimals(max(values), decimals)
    return low if low == high else Tex(f"{low} to {high}")


def matrix(values: ArrayLike, *, exactly: bool = False, digits: int = 6) -> Tex:
    """Return a two-dimensional array as a ``bmatrix``, for use inside mathematics.

    Parameters
    ----------
    exactly : every entry as ``decimal`` writes it; otherwise with ``digits`` significant digits.
    """
    import numpy as np

    array: Floats = np.atleast_2d(np.asarray(values, dtype=np.float64))
    write = decimal if exactly else (lambda v: scientific(v, digits))
    rows = [" & ".join(write(float(v)) for v in row) for row in array]
    return Tex(r"\begin{bmatrix} " + r" \\ ".join(rows) + r" \end{bmatrix}")


def _in_maths(text: str) -> Tex:
    """Return a number that is set as mathematics in text as well as in formulas."""
    return Tex(rf"\ensuremath{{{text}}}")


_TEMPLATES = "takagi.reports.appendix.templates"


def render(template: str, context: Mapping[str, object]) -> str:
    """Return a template filled; a name that the context does not have is an error."""
    return _environment().get_template(template).render(context)


@lru_cache(maxsize=1)
def _environment() -> Environment:
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    environment = Environment(
        block_start_string=r"\BLOCK{",
        block_end_string="}",
        variable_start_string=r"\VAR{",
        variable_end_string="}",
        comment_start_string=r"\#{",
        comment_end_string="}",
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
        undefined=StrictUndefined,
        finalize=escape,
        loader=FunctionLoader(_source),
    )
    environment.filters.update(
        decimal=decimal,
        flat=lambda rows: [float(value) for row in rows for value in row],
        interval=interval,
        listed=listed,
        matrix=lambda rows: matrix(rows, exactly=True),
        places=with_decimals,
        rounded=matrix,
        row=lambda cells: Tex(" & ".join(map(escape, cells)) + r" \\"),
        scientific=scientific,
        tex=lambda text: Tex(str(text).strip()),
    )
    return environment


def _source(name: str) -> str:
    return files(_TEMPLATES).joinpath(name).read_text(encoding="utf-8")


def assembled(
    body: str, context: Mapping[str, object], drawn: Mapping[str, Figure]
) -> dict[str, bytes | str]:
    """Return relative file name -> content of the appendix.

    Parameters
    ----------
    body : the template of the body.
    context : the names that the templates use; the main template needs subject, title, subtitle,
        and whether there is a table of contents.
    drawn : name -> figure.
    """
    figures = {f"{name}.pdf": figure_to_pdf(figure) for name, figure in drawn.items()}
    full_context = {**context, "figures": sorted(figures)}
    files: dict[str, bytes | str] = {
        "appendix.tex": render("appendix.tex.jinja", full_context),
        "appendix-body.tex": render(body, full_context),
        "appendix.bib": _source("references.bib"),
    }
    return files | {f"figures/{name}": data for name, data in figures.items()}


def checked_context(document: Mapping[str, Any], checked: Checked) -> dict[str, Any]:
    """Return the checker's verdict, and the certificate's hashes, versions and configuration."""
    provenance = document.get("provenance", {})
    hashes = {
        **{f"file {name}": value for name, value in provenance.get("files_sha256", {}).items()},
        **{f"certificate: {name}": value for name, value in provenance.get("sha256", {}).items()},
    }
    return {
        "proved": checked.verdict is Verdict.PROVED,
        "verdict": checked.verdict.name,
        "verdict_text": checked.verdict.value,
        "messages": list(checked.messages),
        "hashes": [
            [escape(name), Tex(rf"\texttt{{{escape(value)}}}")] for name, value in hashes.items()
        ],
        "versions": ", ".join(f"{k} {v}" for k, v in provenance.get("versions", {}).items()),
        "model_file": next(iter(provenance.get("files_sha256", {})), ""),
        "configuration": [
            f"{name.replace('_', ' ')} = {law_words(value) if name == 'law' else value}"
            for name, value in provenance.get("configuration", {}).items()
            if value not in (None, {}, [], "") and not isinstance(value, Mapping)
        ],
    }


_RANGES = ("stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")
_SIZES = (
    "integral_rate",
    "residual",
    "wind_gain",
    "effectiveness_slope",
    "reference_slope",
    "lag_disturbance",
)
_CLAIMED = ("multiplier", "wind_error", "wind_rate", "decay_rate")
_PEAKS = {
    "speed_error": r"|e| \le",
    "effort_lag": r"|\zeta| \le",
    "speed_signal": r"|e - x_\mathrm{I}| \le",
    "integral": r"|x_\mathrm{I}| \le",
}


# Nodes of a function of wind that are printed.
MOST_NODES = 40


def certificate_context(design: TurbineDesign) -> dict[str, Any]:
    """Return verdict, theorems and, for the effort-sharing law, the tables of its cells."""
    context = checked_context(design.document, design.checked)
    context |= theorems_context(design.document, design.checked)
    # The matrix of the loop stands beside its theorem; those of its cells are too many to print.
    context |= {"loop": None, "matrices": [], "tables": [], "running": None}
    for order, theorem in enumerate(context["theorems"], start=1):
        claim, kind = theorem["claim"], theorem["claim"].get("kind")
        claim["order"] = order
        if kind == "coherent-loop":
            context["loop"] = _loop(claim, design) | {"order": order}
        elif kind == "wind-rate":
            claim["spans"] = [_span_of_winds(span) for span in claim["ranges"]]
            context["tables"].append(_rates_table(claim))
        elif kind == "bumpless":
            claim |= _actuator_sizes(claim, design) | {"listed": context["loop"] is not None}
            # Schulte's law has hundreds of cells.
            if claim["listed"]:
                context["tables"].append(_actuators_table(claim, context["loop"]))
        elif kind == "running-loop":
            claim["spans"] = [Tex(f"{interval(ends)}~m/s") for ends in claim["winds"]]
            claim["order_of"] = len(claim["cells"][0]["P"])
            context["running"] = order if theorem["proved"] else None
    return context


def _span_of_winds(span: Mapping[str, Any]) -> Tex:
    ends = interval((span["wind"][0], span["wind"][-1]))
    low, high = (decimal(f(span["estimate_rate"])) for f in (min, max))
    rates = low if low == high else Tex(f"{low} to {high}")
    error = decimal(span["estimate_error"])
    return Tex(rf"{ends}~m/s with $\eta_v = {error}$~m/s and $a$ of {rates}~m/s$^2$")


def _rates_table(claim: Mapping[str, Any]) -> dict[str, Any]:
    """Return the functions of the first range, at every k-th node where there are many."""
    columns = (claim["ranges"][0][name] for name in ("wind", "estimate_rate", "schedule_rate"))
    nodes = list(zip(*columns, strict=True))
    step = -(-len(nodes) // MOST_NODES)
    rows = [*nodes[:-1:step], nodes[-1]]
    selection = f", {len(rows)} of {len(nodes)} nodes; the certificate has all" if step > 1 else ""
    words = f"functions of the first range{selection}"
    return {"kind": claim["kind"], "order": claim["order"], "words": words,
            "rows": [[decimal(x) for x in node] for node in rows]}  # fmt: skip


def _actuator_sizes(claim: Mapping[str, Any], design: TurbineDesign) -> dict[str, Any]:
    cells, model = claim["cells"], design.document["model"]
    limit = model["torque_rate_limit"]
    return {
        "pitch_most": decimal(max(cell["pitch_rate"] for cell in cells)),
        "torque_most": decimal(max(cell["torque_rate"] for cell in cells)),
        "pitch_limit": escape(at_least(model["pitch_rate_limit"], 6)),
        "torque_limit": decimal(limit),
        "torque_within": sum(cell["torque_rate"] <= limit for cell in cells),
    }


def _actuators_table(claim: Mapping[str, Any], loop: Mapping[str, Any]) -> dict[str, Any]:
    names = ("pitch_rate", "torque_rate")
    rows = [
        [*head[:2], *(decimal(cell[name]) for name in names)]
        for head, cell in zip(loop["claimed"], claim["cells"], strict=True)
    ]
    return {"kind": claim["kind"], "order": claim["order"], "rows": rows}


def _loop(claim: Mapping[str, Any], design: TurbineDesign) -> dict[str, Any]:
    """Return the numbers of theorem and tables, read from the claim that is checked."""
    cells: Sequence[Mapping[str, Any]] = claim["cells"]
    law, rated = design.effort_sharing_law, design.turbine.rated_rotor_speed
    assert law is not None  # the claim is about it
    low, high = claim["uncertainty"].get("power_coefficient", (1, 1))
    fastest = float(max(law.schedule.rotor_speed)) + claim["peaks"]["speed_error"]
    return {
        "claim": claim,
        "power": interval([low, high]) if low < high else None,
        "peaks": [Tex(f"{_PEAKS[name]} {decimal(v)}") for name, v in
                  claim["peaks"].items()],
        "inertia_gain": range_text((cell["inertia_gain"] for cell in cells), 7),
        "decay_range": range_text((cell["decay_rate"] for cell in cells), 5),
        "overspeed": Tex(at_most_to(100 * (fastest / rated - 1), 2)),
        "ranges": [
            [escape(k), _winds(cell), *(decimal(end) for name in _RANGES for end in cell[name])]
            for k, cell in enumerate(cells, start=1)
        ],
        "claimed": [
            [escape(k), _winds(cell), *(decimal(cell[name]) for name in (*_SIZES, *_CLAIMED))]
            for k, cell in enumerate(cells, start=1)
        ],
    }  # fmt: skip


def _winds(cell: Mapping[str, Any]) -> Tex:
    low, high = cell["wind"]
    return Tex(f"{decimal(low)} to {decimal(high)}")


# Of a function of the weights so many matrices are printed.
MOST_MATRICES = 8


def theorems_context(document: Mapping[str, Any], checked: Checked) -> dict[str, Any]:
    """Return the claims in their order, and the different matrices P among them.

    ``theorems`` has (claim, macro, title, proved, verdict, sentence, text): macro is the name of
    the kind in the templates; a kind without one is stated by its sentence.  The claim has the
    member ``number`` of its P.  ``matrices`` has (number,
    P exactly as emitted, its levels).
    """
    rows: list[dict[str, Any]] = []
    numbers: dict[str, tuple[Tex, list[Tex]]] = {}
    for claim, result in zip(document.get("claims", ()), checked.claims, strict=False):
        kind, P = str(claim.get("kind")), claim.get("P")
        words = KINDS_IN_WORDS.get(kind)
        members = dict(claim)
        if is_matrix(P):
            key = json.dumps(P)
            _, levels = numbers.setdefault(key, (matrix(P, exactly=True), []))
            members["number"] = list(numbers).index(key) + 1
            if "level" in claim and (level := decimal(claim["level"])) not in levels:
                levels.append(level)
        if kind.startswith("fuzzy"):
            members |= _weighted(claim)
        members["same"] = _same_set(claim, rows)
        rows.append(
            {
                "claim": members,
                "macro": kind.replace("-", "_"),
                "title": Tex(words.title) if words else escape(result.name),
                "proved": result.verdict.name == "PROVED",
                "verdict": result.verdict.name,
                "sentence": result.text,
                "text": f"{result.name}: {result.text}",
            }
        )
    return {
        "theorems": rows,
        "matrices": [(k, *entry) for k, entry in enumerate(numbers.values(), start=1)],
    }


def _weighted(claim: Mapping[str, Any]) -> dict[str, Any]:
    """Return P(w) of a claim for its theorem: its matrices by exponents, and rates of weights."""
    rates = claim.get("rates", ())
    matrices = [
        (Tex("".join(f"({listed(powers)})" for powers in coefficient["powers"])),
         matrix(coefficient["matrix"], exactly=True))
        for coefficient in claim["P"]
    ]  # fmt: skip
    return {
        "shown": matrices[:MOST_MATRICES],
        "hidden": max(len(matrices) - MOST_MATRICES, 0),
        "of_premises": len(claim["degrees"]) > 1,
        "rates": [Tex(r"\text{any}") if row is None else listed(row) for row in rates],
        "bounded": any(row is not None for row in rates),
    }


def _same_set(claim: Mapping[str, Any], rows: list[dict[str, Any]]) -> int | None:
    """Return the number of the theorem before that proves this claim's set to be invariant."""
    members = ("P", "level", "multiplier", "disturbance", "disturbance_bounds", "disturbance_norm")
    for number, row in enumerate(rows, start=1):
        earlier = row["claim"]
        if row["macro"] == "invariant_ellipsoid" and row["proved"]:
            if all(claim.get(member) == earlier.get(member) for member in members):
                return number
    return None


def is_matrix(value: Any) -> bool:
    """Return whether this is a matrix of numbers; some claims have P in another form."""
    return bool(value) and isinstance(value, list | tuple) and all(
        isinstance(row, list | tuple) and row and all(isinstance(x, int | float) for x in row)
        for row in value
    )  # fmt: skip

"""What is said of a claim about rests: which laws, which winds, which answers."""

from __future__ import annotations

from fractions import Fraction
from typing import Any
from unittest.mock import patch

from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.equilibria import equilibrium_claim as equilibrium
from takagi.certificates.checker.turbine.equilibria.published import PublishedEquilibria, bends
from takagi.certificates.checker.turbine.equilibria.zero_count import Count, Span
from takagi.certificates.checker.words.saying import in_words
from tests.certificates.pinned.turbine.inputs import as_read, read
from tests.certificates.pinned.turbine.inputs import read as coherent_read
from tests.certificates.pinned.turbine.paper_numbers import LAWS
from tests.certificates.pinned.turbine.rests_of_paper import WINDS, paper_law, paper_turbine
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction


def of_claims_of_rests() -> Named:
    """Yield what is said of a claim whose cells are answered as told."""
    answers: dict[int, Any] = {3: "one", 4: "none", 5: "one", 6: Refused("not known")}

    def answer(winds: Span) -> str:
        found: Any = answers[int(winds[0])]
        if isinstance(found, Refused):
            raise found
        return str(found)

    def told(*cells: tuple[float, float, str]) -> Any:
        stated = [{"wind": [low, high], "rests": rests} for low, high, rests in cells]
        claim = as_read({"cells": stated})
        reader = "law", (F(3), F(7)), answer
        with patch.object(equilibrium, "equilibrium_reader", lambda *_: reader):
            found = said(equilibrium.check_equilibrium, claim, {}, {}, "here")
        if isinstance(found, str):
            return found
        claimed = in_words(found)
        return claimed.verdict.name, claimed.name, claimed.text

    yield "one", told((3, 4, "one"))
    yield "all", told((3, 4, "one"), (4, 5, "none"), (5, 6, "one"))
    yield "several", told((3, 3.5, "one"), (3.5, 4, "one"), (5, 7, "one"))
    yield "wrong", told((3, 4, "none"), (4, 5, "none"))
    yield "not known", told((6, 7, "one"))
    yield "many wrong", told(*((3, 3 + k / 100, "none") for k in range(1, 15)))
    for low, high, rests in (
        (2, 4, "one"), (6, 8, "one"), (5, 5, "one"), (5, 4, "one"), (4, 5, "two"), (6, 7, "one"),
    ):  # fmt: skip
        yield f"{low} to {high} {rests}", told((low, high, rests))
    yield "none", told()
    cells = [(3, 4, "one")]
    for count in (2000, 2001):
        yield f"{count} cells", str(told(*(cells * count)))[:200]
    others: tuple[dict[str, Any], ...] = ({}, {"cells": 1}, {"cells": {}})
    for wrong in others:
        with patch.object(
            equilibrium, "equilibrium_reader", lambda *_: ("law", (F(3), F(7)), answer)
        ):
            yield f"{wrong}", said(equilibrium.check_equilibrium, wrong, {}, {}, "here")


def of_readers() -> Named:
    """Yield for which laws rests are answered, and for which winds."""
    for name in (*LAWS, "torque"):
        data = read(name) if name in LAWS else coherent_read(name)
        model, gains = data["model"], data["gains"]
        yield name, said(equilibrium.equilibrium_reader, model, gains)[:2]
        for key in ("pitch_min", "pitch_max"):
            other = {**gains, key: Number("0.5")}
            yield f"{name}, other {key}", said(equilibrium.equilibrium_reader, model, other)
    gains = read("paper")["gains"]
    for top in ("44093.54", "44093.55", "44093.56", "43093"):
        other = {**gains, "coupling": {**gains["coupling"], "top_torque": Number(top)}}
        yield f"top torque {top}", str(said(equilibrium.equilibrium_reader, model, other))[:60]


def of_pieces_of_winds() -> Named:
    """Yield the answer to each kind of count, and over a bend of the reference speed."""
    plant, law = paper_turbine(), paper_law("paper")
    one = Count(1, 1, 1, -1, ())
    counts = [
        PublishedEquilibria(one, True), PublishedEquilibria(one, False), PublishedEquilibria(one),
        PublishedEquilibria(one, None, WINDS["slow"]),
        PublishedEquilibria(Count(0, 0, 1, 1, ())), PublishedEquilibria(Count(2, 2, 1, 1, ())),
        PublishedEquilibria(Count(2, None, 1, 1, ())),
        PublishedEquilibria(Count(1, None, 1, 1, ())),
        PublishedEquilibria(Count(0, None, 1, 1, ())), PublishedEquilibria(Count(1, 2, 1, 1, ())),
    ]  # fmt: skip
    for number, rests in enumerate(counts):
        with patch.object(equilibrium, "published_equilibria", lambda *_, r=rests: r):
            yield f"piece {number}", said(equilibrium._published_piece, plant, law, WINDS["slow"])
    bend = sorted(bends(plant, law))[1]
    step = F(1, 10)
    for low, high in ((-1, 1), (0, 1), (-1, 0), (-2, -1)):
        seen: list[Any] = []

        def piece(_: Any, __: Any, winds: Span, seen: list[Any] = seen) -> str:
            seen.append(winds)
            return "one" if winds[1] <= bend else "none"

        with patch.object(equilibrium, "_published_piece", piece):
            found = said(
                equilibrium._published, plant, law, (bend + low * step, bend + high * step)
            )
        yield f"over a bend {low} {high}", (found, seen)


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    return {
        "claims of rests": of_claims_of_rests,
        "readers of rests": of_readers,
        "pieces of winds": of_pieces_of_winds,
    }

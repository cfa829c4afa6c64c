"""Claims about the loop of model and gains: how their fields are read.

A kind is a dataclass.  Each member of a claim in the file is one field of it, with a reader, a unit
and, for a matrix, a shape in the sizes of the loop:

    n   states,    2n   states and estimation errors,    m   inputs
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from fractions import Fraction
from typing import Any, Self

from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.kernel.claim_kind import ClaimKind
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.reader import read_matrix
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.figure import Figure, WindProfile

NOT_DEFINITE = "P is not symmetric positive definite"


@dataclass(frozen=True)
class LoopClaim(ClaimKind):
    """A claim about a loop.

    Attributes
    ----------
    claim, where : the claim in the file, and its place for messages.
    loop : the loop of model and gains.
    """

    claim: Any = field(repr=False)
    loop: PolytopicLoop = field(repr=False)
    where: str
    name: str

    @classmethod
    def read(cls, claim: Any, loop: PolytopicLoop, where: str) -> Self:
        """Return the claim with its fields.

        Raises
        ------
        CertificateError : a field that is missing, of another shape, or out of its bounds.
        """
        name = reader.text(claim, "name", where)
        values = {
            field.name: field.metadata["read"](claim, field.name, where, loop)
            for field in fields(cls)
            if "read" in field.metadata
        }
        return cls(claim, loop, where, name, **values)

    def figures(self) -> Iterator[Figure | WindProfile]:
        """Yield the fields that are figures."""
        for one in fields(self):
            value, better = getattr(self, one.name), one.metadata.get("better")
            if not better or value is None:
                continue
            name = one.metadata["label"] or one.name.replace("_", " ")
            rows = value if isinstance(value, list) else [value]
            for k, number in enumerate(rows, start=1):
                counted = f"{name} {k}" if isinstance(value, list) else name
                yield Figure(counted, one.metadata["unit"], number, better == "larger")


def number(
    unit: str = "-",
    *,
    better: str = "",
    label: str = "",
    positive: bool = False,
    optional: bool = False,
) -> Any:
    """Return a field for one number; None where it is optional and left out.

    Parameters
    ----------
    better : "larger" or "smaller" for a figure of the claim; empty for a number that is none.
    label : the figure's name, where that is not the field's.
    """

    def read(claim: Any, key: str, where: str, loop: PolytopicLoop) -> Fraction | None:
        if optional and key not in claim:
            return None
        return (reader.positive if positive else reader.number)(claim, key, where)

    return field(metadata={"read": read, "unit": unit, "better": better, "label": label})


def numbers(
    count: str, unit: str = "-", *, better: str = "", label: str = "", optional: bool = False
) -> Any:
    """Return a field for a row of numbers, e.g. ``numbers("m")`` for one of each input.

    The other parameters are those of ``number``.
    """

    def read(claim: Any, key: str, where: str, loop: PolytopicLoop) -> list[Fraction] | None:
        if optional and key not in claim:
            return None
        return reader.numbers(claim, key, where, size_of(count, loop, where))

    return field(metadata={"read": read, "unit": unit, "better": better, "label": label})


def matrix(rows: str, columns: str) -> Any:
    """Return a field for a matrix, e.g. ``matrix("n", "n")`` for P."""

    def read(claim: Any, key: str, where: str, loop: PolytopicLoop) -> Matrix:
        shape = size_of(rows, loop, where), size_of(columns, loop, where)
        return read_matrix(claim, key, where, shape)

    return field(metadata={"read": read})


def size_of(size: str, loop: PolytopicLoop, where: str) -> int:
    """Return n, 2n or m of a loop.

    Raises
    ------
    CertificateError : m of a loop without gains.
    """
    if size == "m":
        if not loop.K:
            raise CertificateError(f"{where}: the claim is about u = -Kx, but there are no gains")
        return loop.K[0].shape[0]
    return loop.order if size == "n" else 2 * loop.order

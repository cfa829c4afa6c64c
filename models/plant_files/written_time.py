"""Times of a plant file: a number in s, or a text with its unit such as "10 ms"."""

from __future__ import annotations

import re
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.models.files.units import parse_unit

if TYPE_CHECKING:
    from takagi.models.files.toml_document import Document

TIME = re.compile(r"\s*([0-9]{0,9}\.?[0-9]{1,9}(?:[eE][-+]?[0-9]{1,2})?)\s*(.*?)\s*")


def seconds(document: Document, field: str, given: Decimal | str) -> Fraction:
    """Return a time in s, exactly.

    Raises
    ------
    ModelError : with file, line and field: a time that is not above 0, or a unit that is not one of
        time.
    """
    written = str(given)
    match = TIME.fullmatch(written)
    if match is None or not float(match[1]) > 0:
        shown = f"{written!r}" if isinstance(given, str) else written
        raise document.error(
            field, f'{shown} was given; a time above 0 is needed, such as "2 s" or "5 min"'
        )
    try:
        unit = parse_unit(match[2] or "s")
    except ModelError as error:
        raise document.error(field, str(error)) from error
    if unit.dimension != parse_unit("s").dimension:
        raise document.error(field, f"{match[2]!r} is no unit of time; s, min and h are some")
    return unit.to_si(Fraction(match[1]))

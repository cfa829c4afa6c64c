"""Numbers of the checker as text: exactly the same text for exactly the same number, or a hash."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from fractions import Fraction
from typing import Any

from takagi.certificates import CertificateError
from takagi.certificates.checker.arithmetic.interval import ONE, Interval
from takagi.certificates.checker.kernel.refusal import Refused

# What is longer is told by its beginning and a hash.
LONGEST, LONGEST_WORDS = 44, 200
Named = Iterator[tuple[str, Any]]


def text(value: Any) -> str:
    """Return a value as short text that no other value has, but for what hashes allow."""
    exact = _exact(value)
    if len(exact) <= (LONGEST_WORDS if isinstance(value, str) else LONGEST):
        return exact
    shown = _near(value)[: LONGEST_WORDS if isinstance(value, str) else LONGEST]
    return f"{shown} #{hashlib.sha256(exact.encode()).hexdigest()[:12]}"


def said(work: Callable[..., Any], *given: Any, **named: Any) -> Any:
    """Return what a call returns, or the words with which it refuses."""
    try:
        return work(*given, **named)
    except (CertificateError, Refused) as error:
        return f"{type(error).__name__}: {error}"


def _exact(value: Any) -> str:
    return _written(value, str, lambda bracket: f"[{bracket.low}, {bracket.high}]")


def _near(value: Any) -> str:
    return _written(
        value,
        lambda number: f"{float(number):.6g}" if abs(number) < ONE else f"{number / ONE:.6g}",
        lambda bracket: f"[{bracket.low / ONE:.6g}, {bracket.high / ONE:.6g}]",
    )


def _written(value: Any, number: Callable[[Any], str], bracket: Callable[[Interval], str]) -> str:
    def entries(values: Any) -> str:
        return ", ".join(_written(entry, number, bracket) for entry in values)

    if isinstance(value, Interval):
        return bracket(value)
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return str(value)
    if isinstance(value, (int, Fraction)):
        return number(value)
    if is_dataclass(value):
        return f"({entries(getattr(value, field.name) for field in fields(value))})"
    if isinstance(value, Mapping):
        return f"{{{entries(entry for pair in value.items() for entry in pair)}}}"
    if isinstance(value, (set, frozenset)):
        return f"{{{entries(sorted(value))}}}"
    if isinstance(value, (Sequence, Iterator, range)):
        return f"[{entries(value)}]"
    raise TypeError(f"{type(value).__name__} has no exact text")

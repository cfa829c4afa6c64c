"""Members that no checker reads: a claim about a turbine's loop that has one is refused.

A checker reads members by their names.  A further one would be passed over: an uncertainty that no
condition has, or a filter of another form, would stand in a claim that is PROVED.  Every room of
this folder lists in its ``members`` what its claims have.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

from takagi.certificates.checker.kernel.refusal import CertificateError

# By name, what an object may have: nothing where the member is no object, None for any names.
Members: TypeAlias = "Mapping[str, Members | None]"


def plain(names: str) -> dict[str, Members | None]:
    """Return members that are no objects."""
    return {name: {} for name in names.split()}


def refuse_further(of: Mapping[str, Members], claim: Any, where: str) -> None:
    """Refuse a claim of a kind in ``of`` that has, or whose objects have, a further member."""
    _refuse(claim, {**plain("kind name"), **of[claim["kind"]]}, where)


def _refuse(stated: Any, known: Members, where: str) -> None:
    if isinstance(stated, list):
        for i, one in enumerate(stated):
            _refuse(one, known, f"{where}[{i}]")
    elif isinstance(stated, dict):
        for name in sorted(stated):
            if name not in known:
                raise CertificateError(f"{where}: {name!a:.60} is not known; leave it out")
            if (inner := known[name]) is not None:
                _refuse(stated[name], inner, f"{where}.{name}")

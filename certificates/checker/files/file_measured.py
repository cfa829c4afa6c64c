"""The field ``measured`` of a plant file against the law of a certificate.

The field lists the outputs that a law has instead of the states.  A certificate may be about a law
with other outputs, or with all states; then it is not about the law that the file asks for.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from takagi.certificates.checker.files.model_content import OtherModel


def compare_measured(gains: Any, file: dict[str, Any], path: Path) -> None:
    """Compare what the law measures with what the plant file lists; the order means nothing.

    Without gains there is no law, and nothing is compared.

    Parameters
    ----------
    file : what the file at ``path`` says, numbers and texts as ``read_toml`` returns them.

    Raises
    ------
    OtherModel : the law measures other outputs; with names.
    """
    if not isinstance(gains, dict):
        return
    theirs = _names(file["measured"], "measured", path) if "measured" in file else None
    ours = None
    if "observer" in gains:
        own = gains["observer"]
        given = own.get("measured") if isinstance(own, dict) else None
        ours = _names(given, "gains.observer.measured", path)
    if theirs == ours:
        return
    if ours is None:
        why = f"the law has all states, the field measured lists {_told(theirs)} alone"
    elif theirs is None:
        why = f"the law measures {_told(ours)}, without the field measured it has all states"
    elif more := ours - theirs:
        why = f"the law measures {_told(more)}, which the field measured does not list"
    else:
        why = f"the field measured lists {_told(theirs - ours)}, which the law does not measure"
    raise OtherModel(f"{path}: not the certificate's plant: {why}")


def _names(listed: Any, where: str, path: Path) -> set[str]:
    """Return the names; an entry of a file is a name, or a table with a name."""
    entries = listed if isinstance(listed, list) else [None]
    names = [one.get("name") if isinstance(one, dict) else one for one in entries]
    found = {name for name in names if type(name) is str}  # a number of the reader is a str too
    if not all(type(name) is str for name in names):
        raise OtherModel(f"{path}: not the certificate's plant: {where} is no list of names")
    return found


def _told(names: set[str] | None) -> str:
    return ", ".join(ascii(name)[1:-1] for name in sorted(names or ())) or "nothing"

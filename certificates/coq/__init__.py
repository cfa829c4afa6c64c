"""A certificate's matrices for the proof assistant Coq (Rocq): ``coq_file``.

definite.v    the decision by computation, and its proof
numerals      a matrix as Coq reads it, with shorter numbers beside it
coq_export    the file: all matrices of a certificate, claim by claim
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.certificates.coq.coq_export import CoqFile, coq_file

__all__ = ["CoqFile", "coq_file"]


def __getattr__(name: str) -> object:
    if name in __all__:
        return getattr(import_module("takagi.certificates.coq.coq_export"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)

"""A certificate's matrices for the proof assistant Coq (Rocq): ``coq_file``.

definite.v    the decision by computation, and its proof
numerals      a matrix as Coq reads it, and a matrix of shorter numbers that proves it
coq_export    the file: all matrices of a certificate, claim by claim
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.coq.coq_export import coq_file as coq_file

__getattr__, __dir__ = lazy_names(__name__)

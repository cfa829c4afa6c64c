"""Kinds of claims that earlier versions read and this one does not."""

from __future__ import annotations

from collections.abc import Sequence

from takagi.certificates.checker.kernel.refusal import CertificateError

NO_LONGER_READ = frozenset(
    {
        "box-enlargement",
        "crossing-probability",
        "equilibrium",
        "no-common-quadratic",
        "quadratic-decay",
        "running-rate",
        "schedule-rate",
        "turbine-crossing",
        "turbulence-speed",
    }
)
# The last commit that reads them all.
LAST_READER = "1e325e61"


def refuse_removed_kinds(kinds: Sequence[str]) -> None:
    """Refuse a file with a claim of a kind that is no longer read.

    Parameters
    ----------
    kinds : of the file's claims, in their order.

    Raises
    ------
    CertificateError : there is such a claim; the sentence names the last commit that reads it.
    """
    for i, kind in enumerate(kinds):
        if kind in NO_LONGER_READ:
            raise CertificateError(
                f"claims[{i}].kind: claims of kind {kind!r} are no longer read; check this file "
                f"with takagi at commit {LAST_READER}, the last that reads them, or make the "
                f"certificate again with 'takagi certify'"
            )

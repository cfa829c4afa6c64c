"""Test that gains depend only on signals that the law knows.

Rules are corners of premises.  If a premise depends on a signal that the law does not know, the law
cannot compute its weights; so rules that differ only in such premises need equal gains.  Then the
unknown weights cancel: sum_i h_i K_i is a sum over the corners of the other premises only.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from takagi.certificates.checker.kernel.matrices import read_stack
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, closed_by
from takagi.certificates.checker.plant.reading import PlantNodes
from takagi.certificates.checker.plant.vertices import corners_of


def check_known(
    plant: PlantNodes, loop: PolytopicLoop, unknown: Collection[str], gains: Any, subject: str
) -> None:
    """Refuse gains that depend on signals which the law does not know.

    Parameters
    ----------
    loop : the vertices of the plant's model, without gains.
    unknown : symbols of these signals.
    subject : what these signals are, in words, such as ``"an error of an actuator"``.

    Raises
    ------
    Refused : rules that differ only in premises with such a signal have different gains, or the
        gains of several rules have other weights than the model's.
    CertificateError : another number of gains than of rules.
    """
    K = read_stack(gains, "K", "gains")
    if len(K) == 1:
        return
    known_premises = [
        k for k, p in enumerate(plant.premises) if not set(unknown) & plant.graph.variables(p.node)
    ]
    corners = list(corners_of(plant.premises))
    if len(corners) != len(K):
        raise CertificateError(f"gains.K: {len(corners)} gains are needed")
    first: dict[tuple[int, ...], int] = {}
    for i, corner in enumerate(corners):
        picks = [pick for pick, _ in corner.values()]
        j = first.setdefault(tuple(picks[k] for k in known_premises), i)
        # Equal gains are read as equal rows over one denominator.
        if K[i] != K[j]:
            raise Refused(
                f"gains {j + 1} and {i + 1} differ, and the rules differ only in {subject}, which "
                "the law does not know"
            )
    if not closed_by(loop, gains, "gains").shared_weights:
        raise Refused("the law's gains go by other weights than the model's rules")

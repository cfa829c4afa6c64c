r"""Claims of kind ``slope-embedding``: differences between two states are blends of slopes.

For f continuously differentiable on a box, which is convex, and any x, xhat, u, w in it

    f(x, u, w) - f(xhat, u, w) = (\int_0^1 f_x(xhat + s (x - xhat), u, w) ds) (x - xhat),

and the same for the outputs y = g(x, u).  If the entries of f_x and g_x are affine in the premises
of ``model.slopes``, and these premises keep their bounds on the box, then the integral is in the
hull of the vertices at the corners of the bounds.  The conditions are those of
``secant-embedding``, with ``model.slopes`` in the place of ``model.embedding``; neither point has
to be the rest.  The error of an observer with weights at the estimate is such a difference.

Source: the mean value theorem in its integral form; Boyd, El Ghaoui, Feron, Balakrishnan (1994),
section 4.3 (recalled).
"""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.kernel.reader import member, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Found, Outcome
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.plant.secant_embedding import check_secant_embedding
from takagi.certificates.checker.plant.sector_embedding import KIND, plant_loop


def check_slope_embedding(claim: Any, model: Any, gains: Any, where: str) -> Outcome:
    """Return PROVED if the slopes of the plant lie in the vertices of ``model.slopes``.

    Raises
    ------
    CertificateError : as ``check_secant_embedding``, and a model without slopes.
    """
    if text(model, "kind", "model") != KIND:
        raise CertificateError(f"{where}: a claim about a plant; model.kind is {model['kind']!a}")
    found = check_secant_embedding(claim, _with_slopes(model), gains, where)
    if isinstance(found, Found):
        return Found(found.verdict, "slope_embedding", found.given)
    return found


def slope_loop(model: Any) -> PolytopicLoop:
    """Return the vertices of the slopes; the claim ``slope-embedding`` is about them."""
    return plant_loop(_with_slopes(model), "model.slopes")


def _with_slopes(model: Any) -> dict[str, Any]:
    slopes = member(model, "slopes", "model")
    if not isinstance(slopes, dict):
        raise CertificateError("model.slopes: an object is needed")
    return {**model, "embedding": {**slopes, "form": "secant"}}

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

from dataclasses import dataclass
from typing import Any

from takagi.certificates.checker.kernel.reader import member
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.plant.secant_embedding import SecantEmbedding
from takagi.certificates.checker.plant.sector_embedding import plant_loop


@dataclass(frozen=True)
class SlopeEmbedding(SecantEmbedding):
    """The slopes of the plant lie in the vertices of ``model.slopes``; see the module."""

    @classmethod
    def embedded(cls, model: Any) -> Any:
        return _with_slopes(model)

    def sentence(self) -> str:
        from_rest, any_two = "differences of the plant from rest are", "differences between any two"
        text = super().sentence()
        assert text.startswith(from_rest)  # the embedding is read with the form "secant"
        return f"{any_two} states, inputs alike, are{text.removeprefix(from_rest)}"


def slope_loop(model: Any) -> PolytopicLoop:
    """Return the vertices of the slopes; the claim ``slope-embedding`` is about them."""
    return plant_loop(_with_slopes(model), "model.slopes")


def _with_slopes(model: Any) -> dict[str, Any]:
    slopes = member(model, "slopes", "model")
    if not isinstance(slopes, dict):
        raise CertificateError("model.slopes: an object is needed")
    return {**model, "embedding": {**slopes, "form": "secant"}}

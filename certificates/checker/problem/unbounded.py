r"""``unbounded``: the objective has no bound.

``form`` "problem".  Let x satisfy every constraint, and let d be a ray: A_k(d) = sum_i d_i A_ik in
K_k for every k, and c'd < 0.  K_k is a convex cone, so that S_k(x + t d) = S_k(x) + t A_k(d) is in
K_k for every t >= 0, and c'(x + t d) + c_0 = c'x + c_0 + t c'd falls without end.  The dual has no
point: <A_i, y> = c_i with y in the dual cones would give 0 <= sum_k <A_k(d), y_k> = c'd.

``form`` "dual".  The dual is to maximise c_0 - <B, y> with <A_i, y> = c_i and y_k in the dual cone
of K_k.  Let y be such multipliers, and let z be a ray of them: <A_i, z> = 0 with z_k in the dual
cones, and <B, z> < 0.  Then y + t z are multipliers for every t >= 0, and their value rises without
end.  The problem has no solution: z contradicts every one (Farkas).

``point`` is x or y, ``ray`` d or z.  The equations of both have the same left side; they are solved
exactly in the places of ``basis``.

Source: Rockafellar (1970), Convex Analysis, section 8, for directions of recession; Luo, Sturm,
Zhang (2000), Conic convex programming and self-dual embedding, Optimization Methods and Software
14, for such rays of conic problems and of their duals.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, ClassVar, Self

from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.kernel.obligation import Obligations, positive
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.problem.conic_problem import inside_cones
from takagi.certificates.checker.problem.feasible_point import FeasiblePoint
from takagi.certificates.checker.problem.no_solution import NoSolution
from takagi.certificates.checker.problem.optimum_bound import OptimumBound
from takagi.certificates.checker.problem.problem_claim import ProblemClaim

FORMS = ("problem", "dual")


@dataclass(frozen=True)
class Unbounded(ProblemClaim):
    """A point with a ray along which the objective falls without end; see the module.

    Attributes
    ----------
    form : whether point and ray are those of the problem or of its dual.
    ray : the decimals that the file states, as many as of ``point``.
    """

    asks: ClassVar[tuple[str, ...]] = ("form",)
    form: str
    ray: list[Fraction] = field(repr=False)

    @classmethod
    def read(cls, claim: Any, data: Any, where: str) -> Self:
        form = reader.text(claim, "form", where)
        if form not in FORMS:
            raise CertificateError(f"{where}.form: one of {', '.join(FORMS)} is needed")
        kind = FeasiblePoint if form == "problem" else NoSolution
        start = kind.read(claim, data, where)
        ray = reader.numbers(claim, "ray", where, len(start.point))
        return cls(where, start.name, start.problem, start.point, start.basis, form, ray)

    def obligations(self) -> Obligations:
        if self.form == "dual":
            stated = (self.where, self.name, self.problem)
            yield from OptimumBound(*stated, self.point, self.basis).obligations()
            yield from NoSolution(*stated, self.ray, self.basis).obligations()
            return
        start = FeasiblePoint(self.where, self.name, self.problem, self.point, self.basis)
        yield from start.obligations()
        ray = replace(start, problem=self.problem.homogeneous, point=self.ray)
        values = ray.problem.values(ray.x)
        yield from inside_cones(ray.problem.blocks, values, "the ray")
        yield positive(-ray.value, "the objective does not fall along the ray")

    def sentence(self) -> str:
        falls, rises = ("rises", "falls") if self.problem.maximised else ("falls", "rises")
        if self.form == "dual":
            return (
                f"the objective of the dual {rises} without end along the stated ray of "
                "multipliers; no point satisfies the constraints"
            )
        return (
            f"the objective {falls} without end from the stated point along the stated ray; "
            "the dual has no solution"
        )

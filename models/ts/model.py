"""The vertex form of a Takagi-Sugeno model: matrices, premises, rules, box, and its derivation."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats, ShortRepr
from takagi.models.equations.derivation_step import Step
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Number, exact
from takagi.models.ts.premise import Premise
from takagi.models.ts.vertex_arrays import (
    VertexProduct,
    check_corners,
    check_unique,
    matrices_of_systems,
    stored_matrices,
)

if TYPE_CHECKING:
    from takagi.models.equations.equations import Factored
    from takagi.models.equations.problem import Problem
    from takagi.models.plant.plant import Plant
    from takagi.models.ranges.expression_range import Domain


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicForm:
    """The symbols behind a model of ``sector_model``.

    Attributes
    ----------
    plant : as it was given.
    problem : equations in deviations from the equilibrium, box and domain.
    factored : A, B, C, D, E with entries in premise symbols, and what each premise stands for.
    kind : "sector" where f = A(z) x + ..., "secant" where A(z), ... are the slopes of f.
    """

    plant: Plant
    problem: Problem
    factored: Factored
    kind: Literal["sector", "secant"] = "sector"


# Characters that LaTeX reads as commands, written out.
SPECIAL = {letter: f"\\{letter}" for letter in "&%$#_{}"} | {
    "\\": r"\textbackslash{}",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
}


@dataclass(frozen=True, slots=True)
class Derivation:
    """The steps from the plant's equations to the vertex matrices, in order.

    ``exactness`` says how it was checked that the factored form is the plant; empty when nothing
    is said.  ``form`` has the plant, its factored form and its premises in symbols, where the model
    was derived from symbols.
    """

    steps: tuple[Step, ...]
    exactness: str = ""
    form: SymbolicForm | None = field(default=None, repr=False, compare=False)

    @property
    def latex(self) -> str:
        r"""The whole derivation as LaTeX paragraphs with ``\[ ... \]`` displays (amsmath)."""
        paragraphs = []
        for step in self.steps:
            title = "".join(SPECIAL.get(letter, letter) for letter in step.title)
            paragraphs.append(f"{title}\n\\[\n{step.latex}\n\\]")
        return "\n".join(paragraphs)


Rule: TypeAlias = tuple[int, ...]
LETTERS = ("A", "B", "C", "D", "E")


class Matrices(NamedTuple):
    """One linear system: xdot = A x + B u + E w, y = C x + D u."""

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    E: Floats


@dataclass(frozen=True, slots=True, eq=False, init=False, repr=False)
class TSModel(ShortRepr):
    """Vertex form xdot = sum_i h_i(z) (A_i x + B_i u + E_i w), y = sum_i h_i(z) (C_i x + D_i u).

    With premises z_k in [lower_k, upper_k] rule i takes corner c_ik (0 lower, 1 upper) of each,
    and h_i = prod_k w_k,c_ik with w_k0 = (upper_k - z_k)/(upper_k - lower_k), w_k1 = 1 - w_k0, so
    h_i >= 0 and sum_i h_i = 1.  Without premises the vertices are a polytope of linear systems.

    Parameters
    ----------
    A : (r, n, n); or r state spaces of python-control or scipy, in the same states, which bring
        B, C, D and the sample time; or a ``VertexProduct``, and then B, C, D, E are such or None:
        the vertices of each matrix are made when it is first asked for.
    B : (r, n, m), or (n, m) for the same in every vertex; None for no input.
    C, D, E : (r, p, n), (r, p, m), (r, n, q), or without r; None for no output, no direct
        feed-through, no disturbance.
    states, inputs, outputs, disturbances : names with units, e.g. ``"rotor speed [rad/s]"``; None
        takes x1 [-], x2 [-], ..., u1 [-], y1 [-], w1 [-].
    premises : the z_k.  A constant one (lower == upper) costs no rule.
    rules : the c_i, one tuple of corner indices per vertex; None takes every combination, the
        last premise changing first.
    box : variable with unit -> (lower, upper): where the model equals its plant.
    sample_time : T in s of a model in discrete time, x(t + T) in the place of xdot; None for
        continuous time.
    name, source : what it is, and where the numbers come from.
    derivation : how it was derived; None when it was given as matrices.

    ``products`` holds the matrices entry by entry, where they were given so.

    All arrays are read-only float64 copies; C, D, E, B are always (r, ., .) afterwards.

    Raises
    ------
    ModelError : a shape that does not fit, an entry that is not finite, names that do not fit or
        are not unique, rules that do not match the vertices or the premises, a sample time that
        is not positive.

    Source: Tanaka and Wang (2001), Fuzzy Control Systems Design and Analysis, section 2.2.
    """

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    E: Floats
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    disturbances: tuple[str, ...]
    premises: tuple[Premise, ...]
    rules: tuple[Rule, ...]
    box: Mapping[str, tuple[Fraction, Fraction]]
    sample_time: float | None
    name: str
    source: str
    derivation: Derivation | None
    products: Mapping[str, VertexProduct]

    def __init__(
        self,
        A: ArrayLike | VertexProduct | Sequence[Any],
        B: ArrayLike | VertexProduct | None = None,
        *,
        C: ArrayLike | VertexProduct | None = None,
        D: ArrayLike | VertexProduct | None = None,
        E: ArrayLike | VertexProduct | None = None,
        states: Sequence[str] | None = None,
        inputs: Sequence[str] | None = None,
        outputs: Sequence[str] | None = None,
        disturbances: Sequence[str] | None = None,
        premises: Sequence[Premise] = (),
        rules: Sequence[Sequence[int]] | None = None,
        box: Mapping[str, tuple[Number, Number]] | None = None,
        sample_time: float | None = None,
        name: str = "",
        source: str = "",
        derivation: Derivation | None = None,
    ) -> None:
        labels = {
            "states": states,
            "inputs": inputs,
            "outputs": outputs,
            "disturbances": disturbances,
        }
        members = tuple(premises)
        check_unique("premises", [premise.name for premise in members])
        matrices, sample_time = matrices_of_systems(
            {"A": A, "B": B, "C": C, "D": D, "E": E}, sample_time
        )
        arrays, names, products, count = stored_matrices(matrices, labels)
        check_corners(products, members, rules)
        values: dict[str, object] = {**arrays, **names, "premises": members, "products": products}
        values["rules"] = _rules(members, rules, count)
        values["box"] = _box(box or {})
        values["sample_time"] = _positive(sample_time)
        values |= {"name": name, "source": source, "derivation": derivation}
        for member, value in values.items():
            object.__setattr__(self, member, value)

    if not TYPE_CHECKING:

        def __getattr__(self, name):
            # Reached only while the field has no value: the matrices of a product are made once.
            if name in LETTERS:
                stack = self.products[name].stack()
                object.__setattr__(self, name, stack)
                return stack
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    @property
    def vertices(self) -> tuple[Matrices, ...]:
        """The linear systems at the vertices, in rule order."""
        return tuple(
            Matrices(*matrices)
            for matrices in zip(self.A, self.B, self.C, self.D, self.E, strict=True)
        )

    @property
    def sampled(self) -> tuple[str, ...]:
        """Names of premises whose bounds rest on samples: with them nothing is proved."""
        return tuple(premise.name for premise in self.premises if premise.sampled)

    @property
    def domain(self) -> Domain | None:
        """Where the model equals its plant, if that is less than its box; None for the box."""
        return next((p.domain for p in self.premises if p.domain is not None), None)

    def memberships(
        self, values: ArrayLike | None = None, /, *, clip: bool = False, **premise_values: ArrayLike
    ) -> Floats:
        """Return h(z) of shape (r,), or (r, ...) for premise values given as arrays.

        Parameters
        ----------
        values : z of shape (number of premises, ...), in the model's order; or name each premise.
        clip : False refuses a premise outside its bounds; True moves it to the nearer bound (for
            run time: outside its box the model is not exact).

        Raises
        ------
        ModelError : a premise missing, unknown, not a number, or outside its bounds.
        """
        if not self.premises and values is None and not premise_values and len(self.rules) == 1:
            return np.ones(1)
        z = self._premise_array(values, premise_values)
        shares = np.ones((1, *z[0].shape))
        for premise, value in zip(self.premises, z, strict=True):
            weights = premise.weights(value, clip=clip)
            shares = (shares[:, None] * weights[None]).reshape(-1, *z[0].shape)
        sizes = tuple(len(premise.corners) for premise in self.premises)
        order = np.ravel_multi_index(tuple(np.array(self.rules).T), sizes)
        return np.asarray(shares[order], dtype=np.float64)

    def blend(
        self, values: ArrayLike | None = None, /, *, clip: bool = False, **premise_values: ArrayLike
    ) -> Matrices:
        """Return sum_i h_i(z) (A_i, B_i, C_i, D_i, E_i); arguments as for ``memberships``.

        Shapes are (n, n), ... for one z, and (..., n, n), ... for arrays of premise values.
        """
        h = np.moveaxis(self.memberships(values, clip=clip, **premise_values), 0, -1)
        stacks = (self.A, self.B, self.C, self.D, self.E)
        return Matrices(*(np.tensordot(h, stack, axes=1) for stack in stacks))

    def premise_values(self, **point: float) -> Floats:
        """Return z, (number of premises,), at an operating point given by keyword.

        Which keywords there are is said by the maker of the model.

        Raises
        ------
        ModelError : a premise carries no ``evaluate``.
        """
        values = []
        for premise in self.premises:
            if premise.evaluate is None:
                raise ModelError(
                    f"premise {premise.name} of model {self.name!r} has no evaluate function; "
                    "build the Premise with one, or give its value"
                )
            values.append(premise.evaluate(**point))
        return np.array(values, dtype=np.float64)

    def _premise_array(
        self, values: ArrayLike | None, named: Mapping[str, ArrayLike]
    ) -> tuple[Floats, ...]:
        names = [premise.name for premise in self.premises]
        if not names:
            raise ModelError(
                f"model {self.name!r} has {len(self.rules)} vertices and no premises, so there are "
                "no memberships; give premises, or weigh the vertices yourself"
            )
        if values is None:
            if set(named) != set(names):
                raise ModelError(
                    f"premises {', '.join(named) or 'none'} were given; "
                    f"each of {', '.join(names)} is needed, by name or as one array"
                )
            values = np.stack(np.broadcast_arrays(*(named[name] for name in names)))
        elif named:
            raise ModelError("premise values were given as an array and by name; give one of them")
        z = np.asarray(values, dtype=np.float64)
        if z.ndim == 0 or z.shape[0] != len(names):
            raise ModelError(
                f"premise values have shape {z.shape}; the first axis must be {len(names)} long "
                f"({', '.join(names)})"
            )
        return tuple(z)


def _positive(sample_time: float | None) -> float | None:
    if sample_time is None:
        return None
    if not (math.isfinite(sample_time) and sample_time > 0):
        raise ModelError(
            f"sample_time is {sample_time!r}; a positive number of seconds is needed, or None for "
            "continuous time"
        )
    return float(sample_time)


def _rules(
    premises: tuple[Premise, ...], rules: Sequence[Sequence[int]] | None, count: int
) -> tuple[Rule, ...]:
    corners = [range(len(premise.corners)) for premise in premises]
    if rules is None:
        rule_list: list[Rule] = list(product(*corners)) if premises else [()] * count
        if len(rule_list) == count:
            return tuple(rule_list)
    else:
        rule_list = [tuple(int(corner) for corner in rule) for rule in rules]
    if len(rule_list) != count:
        combinations = math.prod(len(choice) for choice in corners)
        raise ModelError(
            f"A has {count} vertices, but there are {len(rule_list)} rules; one rule per vertex is "
            f"needed ({len(premises)} premises give {combinations} combinations of corners)"
        )
    for index, rule in enumerate(rule_list, start=1):
        if len(rule) != len(premises) or any(
            c not in k for c, k in zip(rule, corners, strict=True)
        ):
            raise ModelError(
                f"rule {index} of {count} is {rule}; one corner per premise is needed: "
                + (
                    ", ".join(
                        f"{p.name} in {list(k)}" for p, k in zip(premises, corners, strict=True)
                    )
                    or "()"
                )
            )
    if premises and set(rule_list) != set(product(*corners)):
        raise ModelError(
            "the rules leave out a combination of corners, so the memberships would not sum to 1; "
            "list every combination once"
        )
    return tuple(rule_list)


def _box(box: Mapping[str, tuple[Number, Number]]) -> Mapping[str, tuple[Fraction, Fraction]]:
    sides = {}
    for variable, (first, last) in box.items():
        lower, upper = exact(first), exact(last)
        if lower > upper:
            raise ModelError(
                f"box of {variable}: lower end {float(lower):.9g} exceeds upper end "
                f"{float(upper):.9g}; give the smaller one first"
            )
        sides[variable] = (lower, upper)
    return MappingProxyType(sides)

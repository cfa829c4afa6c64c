"""Misuse is named: which item, what was given, what to do."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from inspect import Signature, signature
from typing import Any

import numpy as np
import pytest
import scipy.sparse

import takagi.lmi as lmi
from takagi.lmi import lqr_pdc, observer, pdc
from takagi.models import Floats, ModelError, TSModel

# The plants of the table hardly need gains; the shapes are what is tested.
pytestmark = pytest.mark.filterwarnings("ignore::takagi.lmi.ZeroGainsWarning")


@dataclass
class Plain:
    """Only the attributes that are read: a model need not be a TSModel."""

    A: Any
    B: Any


@dataclass
class Seen:
    A: Any
    C: Any


def signature_of(name: str) -> Signature:
    return signature(getattr(lmi, name))


class Framed:
    """A table of another library: numpy reads it, and it has no attribute of ours."""

    def __init__(self, values: object) -> None:
        self._values = values

    def __array__(self, dtype: object = None, copy: bool | None = None) -> Floats:
        return np.asarray(self._values, dtype=dtype)  # type: ignore[call-overload,no-any-return]


A, B, C = np.tile(-np.eye(2), (2, 1, 1)), np.ones((2, 2, 1)), np.ones((2, 1, 2))
Q, R = np.eye(2), np.eye(1)
LEFT = lmi.EigenvalueRegion.half_plane(0.5)

# Each function with what it reads of A, B and C, called with these and options.  A new function
# that reads a model is a line here.
FUNCTIONS: dict[str, tuple[str, Callable[..., object]]] = {
    "common_lyapunov": ("A", lambda A, B, C, **o: lmi.common_lyapunov(A, **o)),
    "common_lyapunov_condition": ("A", lambda A, B, C, **o: lmi.common_lyapunov_condition(A, **o)),
    "max_decay_rate": ("A", lambda A, B, C, **o: lmi.max_decay_rate(A, **o)),
    "d_stability": ("A", lambda A, B, C, **o: lmi.d_stability(A, LEFT, **o)),
    "d_stability_condition": ("A", lambda A, B, C, **o: lmi.d_stability_condition(A, LEFT, **o)),
    "fuzzy_lyapunov": ("A", lambda A, B, C, **o: lmi.fuzzy_lyapunov(A, rate_bounds=0, **o)),
    "fuzzy_lyapunov_condition": (
        "A",
        lambda A, B, C, **o: lmi.fuzzy_lyapunov_condition(A, rate_bounds=0, **o),
    ),
    "pdc": ("AB", lambda A, B, C, **o: lmi.pdc(Plain(A, B), **o)),
    "pdc_condition": ("AB", lambda A, B, C, **o: lmi.pdc_condition(Plain(A, B), **o)),
    "lqr_pdc": ("AB", lambda A, B, C, **o: lmi.lqr_pdc(Plain(A, B), Q, R, **o)),
    "lqr_pdc_condition": ("AB", lambda A, B, C, **o: lmi.lqr_pdc_condition(Plain(A, B), Q, R, **o)),
    "observer": ("AC", lambda A, B, C, **o: lmi.observer(Seen(A, C), **o)),
    "observer_condition": ("AC", lambda A, B, C, **o: lmi.observer_condition(Seen(A, C), **o)),
    "hinf_norm": ("AD", lambda A, B, C, **o: lmi.hinf_norm(A, np.ones((2, 1)), [[1, 1]], **o)),
    "h2_norm": ("AD", lambda A, B, C, **o: lmi.h2_norm(A, np.ones((2, 1)), [[1, 1]], **o)),
}
MANY = tuple(FUNCTIONS)
SYNTHESIS = tuple(name for name, (reads, _) in FUNCTIONS.items() if "B" in reads)
ESTIMATION = tuple(name for name, (reads, _) in FUNCTIONS.items() if "C" in reads)


def call(name: str, *, A: object = A, B: object = B, C: object = C, **options: object) -> object:
    return FUNCTIONS[name][1](A, B, C, **options)


@pytest.mark.parametrize("name", MANY)
def test_the_table_is_called_with_what_makes_sense(name: str) -> None:
    """So that a refusal below is due to the one thing that was changed."""
    assert call(name) is not None
    assert call(name, A=Framed(A)) is not None


def require_refused(names: Iterable[str], message: str, **changed: object) -> None:
    for name in names:
        with pytest.raises(ModelError) as refused:
            call(name, **changed)
            pytest.fail(f"{name} took it")
        assert re.search(message, str(refused.value)), name


@pytest.mark.parametrize(
    ("vertices", "message"),
    [
        (np.zeros((0, 2, 2)), "no vertices; give at least one vertex"),
        (np.zeros((2, 0, 0)), "no states; give at least one vertex of at least one state"),
        (np.zeros((2, 2, 3)), r"\(2, 2, 3\); \(N, n, n\) is needed"),
        (np.zeros(3), r"\(N, n, n\) is needed"),
        (3.0, r"\(N, n, n\) is needed"),
        (np.zeros((1, 2, 2, 2)), r"\(N, n, n\) is needed"),
        ([A[0], [[-1.0, np.nan], [0.0, -1.0]]], r"vertex 2 of 2: A\[0, 1\] is nan; every entry"),
        (
            np.full((2, 2, 2), -np.inf),
            r"vertex 1 of 2: A\[0, 0\] is -inf; every entry must be finite",
        ),
        (1e200 * A, r"vertex 1 of 2: A\[0, 0\] is -1e\+200; entries above 1e\+60 overflow; take"),
        ([[-1.0, "x"], [0.0, -1.0]], "cannot be read.*give nested lists"),
        ([[[1.0]], [[1.0, 2.0]]], "cannot be read.*of equal length"),
        (1j * A, "cannot be read.*complex entries"),
        (None, "cannot be read"),
        ([[None, None], [None, None]], "cannot be read"),
        ("a model", "cannot be read"),
        ({"A": A}, "cannot be read"),
        (np.array([[Fraction(1), "a"], [1, 2]], dtype=object), "cannot be read"),
        (np.zeros((2, 2), dtype="datetime64[D]"), "cannot be read"),
        (np.zeros((2, 2), dtype=[("speed", float)]), "cannot be read"),
        (scipy.sparse.csr_array(A[0]), r"sparse matrix; write .toarray\(\) behind it"),
        (Framed([[np.nan]]), r"A\[0, 0\] is nan"),
        (TSModel, "cannot be read"),
    ],
)
def test_vertices_that_make_no_sense(vertices: object, message: str) -> None:
    require_refused(MANY, message, A=vertices)


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        (np.zeros((2, 2, 1)), "input 1 of 1: its column of B is zero in every vertex.*leave it"),
        (np.tile([[1.0, 2.0], [2.0, 4.0]], (2, 1, 1)), "B: rank 1 over all.*but 2.*merge them"),
        (np.zeros((2, 2, 0)), "no inputs; B needs at least one"),
        (np.ones((3, 2, 1)), r"B has shape \(3, 2, 1\), A has \(2, 2, 2\)"),
        (np.ones((2, 1)), r"B has shape \(2, 1\), A has \(2, 2, 2\); B must be \(r, n, m\)"),
        (np.full((2, 2, 1), np.inf), r"vertex 1 of 2: B\[0, 0\] is inf"),
        (1j * B, "B cannot be read.*complex"),
        (None, "has no B; inputs are needed, give B"),
        ([[["a"], ["b"]]] * 2, "B cannot be read"),
    ],
)
def test_inputs_that_make_no_sense(inputs: object, message: str) -> None:
    require_refused(SYNTHESIS, message, B=inputs)


@pytest.mark.parametrize("name", ESTIMATION)
@pytest.mark.parametrize(
    ("outputs", "message"),
    [
        (np.zeros((2, 1, 2)), "output 1 of 1: its row of C is zero in every vertex"),
        (np.ones((2, 2, 2)), "C: rank 1 over all vertices, but 2 outputs"),
        (np.ones((3, 1, 2)), r"C has shape \(3, 1, 2\), A has \(2, 2, 2\); C must be \(r, p, n\)"),
        (np.full((2, 1, 2), np.nan), r"vertex 1 of 2: C\[0, 0\] is nan"),
        (None, "has no C; outputs are needed, give C"),
    ],
)
def test_outputs_that_make_no_sense(name: str, outputs: object, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        call(name, C=outputs)


@pytest.mark.parametrize(
    ("scales", "message"),
    [
        ([-1.0, 1.0], r"scales\[0\] is -1"),
        ([1.0, 1.0, 1.0], r"scales has shape \(3,\); \(2,\) or one number"),
        ([1.0, np.nan], r"scales\[1\] is nan"),
        ("wide", "scales cannot be read"),
        ([1j, 1.0], "scales cannot be read"),
    ],
)
def test_scales_that_make_no_sense(scales: object, message: str) -> None:
    scaled = [name for name in MANY if not name.endswith("condition") and name != "lqr_pdc"]
    require_refused(scaled, message, scales=scales)


def taking(option: str) -> list[str]:
    return [name for name in MANY if option in signature_of(name).parameters]


@pytest.mark.parametrize("rate", [np.nan, np.inf, "fast", 1j, True, None, np.ones(2), [0.1]])
def test_decay_rates_that_make_no_sense(rate: object) -> None:
    words = "decay_rate is .*; a finite number is needed"
    require_refused(taking("decay_rate"), words, decay_rate=rate)


@pytest.mark.parametrize("step", [0, -1.0, np.nan, "0.1", 1j, True, np.ones(2)])
def test_sample_times_that_make_no_sense(step: object) -> None:
    require_refused(taking("sample_time"), "sample_time is", sample_time=step)


@pytest.mark.parametrize("name", taking("relaxation"))
@pytest.mark.parametrize("relaxation", ["tanaka-wong", "polya--1", "polya-x", "", None, 3])
def test_relaxations_that_there_are_not(name: str, relaxation: object) -> None:
    with pytest.raises(ModelError, match="wang-tanaka-griffin.*polya-<d>"):
        call(name, relaxation=relaxation)


@pytest.mark.parametrize(
    ("vertices", "message"),
    [
        (1j * A, "A cannot be read as an array of numbers .complex entries"),
        ([[[1.0, 0.0], [1.0]]], "A cannot be read as an array of numbers"),
    ],
)
def test_a_model_refuses_what_the_functions_refuse(vertices: object, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        TSModel(vertices)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("A", "B", "said"),
    [
        # A multiple eigenvalue: B moves a combination, another one stays.
        (0.5 * np.eye(2), [[1.0], [1.0]], r"mode at 0.5 .*drift \[m\] .*speed \[m/s\]"),
        # The same in units of the states in which B looks small.
        ([[0.5, 0.0], [0.0, 0.5]], [[1e-9], [1e3]], "mode at 0.5 "),
        # A pair that swings, beside a mode that is reached.
        ([[0.1, 2.0], [-2.0, 0.1]], [[0.0], [0.0]], r"mode at 0.1[+-]2j"),
        # Defective, in coordinates that hide it: eigenvalues are off by a root of the rounding.
        ([[1.5, 1.0], [-1.0, -0.5]], [[1.0], [-1.0]], "mode at 0.5 "),
    ],
)
def test_modes_out_of_reach_of_every_kind(A: object, B: object, said: str) -> None:
    first, second = np.array([[0.0, 1.0], [0.0, 0.0]]), np.asarray(A)
    inputs = np.array([[[0.0], [1.0]], B])
    model = TSModel(np.array([first, second]), inputs, states=["drift [m]", "speed [m/s]"])

    for synthesis in (pdc, lambda m: lqr_pdc(m, Q, R)):
        with pytest.raises(ModelError, match=f"vertex 2 of 2: the {said}.*change B or the box"):
            synthesis(model)


def test_a_mode_that_no_output_shows_is_named_for_an_observer() -> None:
    model = TSModel(
        np.array([np.diag([-1.0, 0.5])]), C=[[1.0, 0.0]], states=["speed [m/s]", "drift [m]"]
    )

    with pytest.raises(
        ModelError, match=r"mode at 0.5 \(\+1 \* drift \[m\]\).*no output; change C"
    ):
        observer(model)


@pytest.mark.parametrize("mode", [1.0, 1.05, -1.2])
def test_in_discrete_time_a_mode_counts_outside_the_open_unit_disc(mode: float) -> None:
    """At 1 it does not decay; at 0.99 it does, so that the other mode decides."""
    stuck = TSModel([np.diag([mode, 0.5])], [[0.0], [1.0]], sample_time=0.1)
    slow = TSModel([np.diag([0.99, 1.5])], [[0.0], [1.0]], sample_time=0.1)

    with pytest.raises(ModelError, match=f"vertex 1 of 1: the mode at {mode:g}, not inside the"):
        pdc(stuck)
    assert pdc(slow).found
    # log(1 / 0.99) / 0.1 s = 0.1005 1/s is as fast as that mode is.
    assert pdc(slow, decay_rate=0.1).found
    assert pdc(slow, decay_rate=0.102).status == "infeasible"


def test_an_input_may_do_nothing_in_one_vertex() -> None:
    """B of that vertex has less than full rank; over all vertices the inputs are independent."""
    A = np.tile([[0.0, 1.0], [0.5, 0.0]], (2, 1, 1))
    B = np.array([np.eye(2), [[0.0, 0.0], [0.0, 1.0]]])

    assert pdc(TSModel(A, B)).found


def test_a_vertex_without_authority_is_legal_where_it_is_stable() -> None:
    """Pitch does nothing in partial load; that vertex decays by itself."""
    A = np.array([[[-0.1]], [[0.5]]])
    design = pdc(TSModel(A, [[[0.0]], [[1.0]]]), relaxation="wang-tanaka-griffin")

    assert design.status in ("candidate", "infeasible")


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ({"decay_rate": np.nan}, "decay_rate is nan"),
        ({"decay_rate": "fast"}, "decay_rate is 'fast'"),
        ({"input_limit": [0.0]}, r"input_limit\[0\] is 0"),
        ({"input_limit": [1.0, 2.0]}, r"input_limit has shape \(2,\)"),
        ({"initial_box": [1.0], "state_box": [0.5]}, "state 1: the initial box reaches to 1"),
        ({"gain_bound": -1.0}, "gain_bound is -1"),
        ({"scales": [-1.0]}, r"scales\[0\] is -1"),
        ({"state_box": [-np.inf]}, r"state_box\[0\] is -inf"),
    ],
)
def test_options_that_make_no_sense(option: dict[str, object], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        pdc(TSModel([[[1.0]]], [[[1.0]]]), **option)  # type: ignore[arg-type]


def test_small_units_are_not_taken_for_no_authority() -> None:
    """A torque in N m moves a rotor by 1e-12 of its unit; that is authority all the same."""
    model = TSModel([[[0.1, 0.0], [0.0, -5.0]]], [[[-1e-12, 0.0], [0.0, 5.0]]])

    assert pdc(model, decay_rate=0.05).found

r"""The form whose definiteness means that V falls while the wind moves, and the functions of V.

Rows of the loop are over (xi, two inputs, w), with w_f^2 <= (z_f xi)^2 for each uncertain factor f.
With F the rows, Z the z_f, T = diag(tau_f) and B = diag(b_1, b_2), the form is

    diag(-S, B, T)  -  [ P F; 0 ]  -  [ P F; 0 ]'  -  Z' T Z ,

S = 2 alpha P + D, D the rate of P.  A factor that is one number has no z_f, and no tau_f.

Written from docs/running-rate.md and docs/schedule-rate.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import entries
from takagi.certificates.cross_check.kernel.reading import Refusal, entry, rational, table
from takagi.certificates.cross_check.turbine.running.rates import Row
from takagi.certificates.cross_check.turbine.running.running_loop import MOST_CELLS


def functions_by_wind(claim: Any, n: int) -> dict[str, fmpq_mat]:
    """Return P by its wind; one wind has one function, so that V is continuous over wind."""
    stated, found = entry(claim, "functions"), {}
    if not isinstance(stated, list) or len(stated) > 2 * MOST_CELLS:
        raise Refusal("functions: a list is needed")
    for one in stated:
        wind = str(rational(one, "wind"))
        if wind in found:
            raise Refusal("functions: two at one wind")
        found[wind] = table(one, "P", (n, n))
    return found


def moving_form(
    rows: Sequence[Row],
    inputs: Sequence[int],
    factors: Mapping[str, tuple[int, Row]],
    P: fmpq_mat,
    tau: Mapping[str, fmpq],
    shift: fmpq_mat,
    weights: tuple[fmpq, fmpq],
) -> fmpq_mat:
    """Return the matrix of the module.

    Parameters
    ----------
    rows : xi', one row a state.
    inputs : the columns of the two inputs.
    factors : by name, the column of w_f and the row z_f, in the order of the matrix.
    shift : S.
    weights : b_1 and b_2.
    """
    n = len(rows)
    used = [name for name, (_, row) in factors.items() if any(row)]
    first = n + len(inputs)
    kept = [*range(n), *inputs, *(factors[name][0] for name in used)]
    size = len(kept)
    PF = entries(P * fmpq_mat([[row[j] for j in kept] for row in rows]))
    M = [[fmpq(0)] * size for _ in range(size)]
    for i in range(n):
        for j in range(n):
            M[i][j] -= shift[i, j]
        for j in range(size):
            M[i][j] -= PF[i][j]
            M[j][i] -= PF[i][j]
    for i, weight in enumerate(weights):
        M[n + i][n + i] += weight
    for i, name in enumerate(used):
        M[first + i][first + i] += tau[name]
        z = [(a, factors[name][1][j]) for a, j in enumerate(kept) if factors[name][1][j] != 0]
        for a, x in z:
            for b, y in z:
                M[a][b] -= tau[name] * x * y
    return fmpq_mat(M)

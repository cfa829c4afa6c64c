r"""Controllers nearer to the least norm, and controllers without absurd entries.

The central controller, by two Riccati equations: with R = D1' D1 - diag(gamma^2 I, 0) for
D1 = [D11, D12], and R~ = D2 D2' - diag(gamma^2 I, 0) for D2 = [D11; D21],

    F = -R^-1 (D1' C1 + B' X),    L = -(B1 D2' + Y C') R~^-1,    Z = (I - Y X / gamma^2)^-1,

and a controller from them.  Where D12 or D21 is singular, a little of u is added to z, of noise to
y: what bounds more bounds less.  Nothing of this is trusted: the loop's own norm is computed.

As a norm comes near its least value a pole of the controller goes to infinity.  Long before, what
it does at the loop's frequencies is a gain, which takes its place (residualisation).

Source: Zhou, Doyle, Glover (1996), Robust and Optimal Control, theorem 17.1; Gahinet (1996),
Automatica 32, on the order at the optimum; Fernando and Nicholson (1982), IEEE Trans. Automatic
Control 27, on singular perturbation.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np

from takagi.lmi.analysis.disturbance.guessed_function import norm_seen
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.gains.output_feedback.generalised_plant import GeneralisedPlant, StateSpace
from takagi.models.arrays import Floats

# Weight of u in z and of noise in y, where there is none: shares of those of x and w.
LITTLE, WEIGHTS = 1e-5, (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
# Steps of the bisection of the norm.
STEPS = 14
# Rounds of the balancing of states.
ROUNDS = 8
# Entries below this share of their row are rounding.
ROUNDING = 1e-9


def loop_norm(plant: GeneralisedPlant, controller: StateSpace) -> float:
    """Return the H-infinity norm of the loop that a frequency search sees; inf where unstable."""
    loop = plant.closed(controller)
    if not (np.isfinite(loop.A).all() and np.linalg.eigvals(loop.A).real.max() < 0):
        return np.inf
    return norm_seen(loop.A, loop.B, loop.C, loop.D)


def nearer_controller(
    plant: GeneralisedPlant, low: float, high: float, enough: float
) -> tuple[StateSpace, float] | None:
    """Return the central controller with the least norm that a bisection finds, and the norm.

    ``low``, ``high`` : norms between which it is sought.
    ``enough`` : relative; the bisection ends where low and high are as near.
    """
    best: tuple[StateSpace, float] | None = None
    full = _with_little(plant, LITTLE)
    low = max(low, 1e-9 * high)
    for _ in range(STEPS):
        middle = float(np.sqrt(low * high)) if high > 2 * low else (low + high) / 2
        controller = _central(full, middle)
        norm = np.inf if controller is None else loop_norm(plant, controller)
        if controller is not None and norm < high:
            best, high = (controller, norm), norm
        else:
            low = middle
        if high <= (1 + enough) * low:
            break
    return best


def central_controllers(plant: GeneralisedPlant, gamma: float) -> Iterator[StateSpace]:
    """Yield controllers for a norm of at most gamma, those first that have u and noise weighed."""
    for share in WEIGHTS:
        controller = _central(_with_little(plant, share), gamma)
        if controller is not None and loop_norm(plant, controller) <= gamma:
            yield in_even_states(controller)


def _with_little(plant: GeneralisedPlant, share: float) -> GeneralisedPlant:
    """Return the plant with a little of u in z, and of noise in y, where these are singular."""
    B1, C1, D11, D12, D21 = plant.B1, plant.C1, plant.D11, plant.D12, plant.D21
    if not _full(D12):
        m = D12.shape[1]
        size = share * (float(np.linalg.norm(C1, 2)) or 1.0)
        C1, D11 = (np.vstack([matrix, np.zeros((m, matrix.shape[1]))]) for matrix in (C1, D11))
        D12 = np.vstack([D12, size * np.eye(m)])
    if not _full(D21.T):
        k = len(D21)
        size = share * (float(np.linalg.norm(B1, 2)) or 1.0)
        B1, D11 = (np.hstack([matrix, np.zeros((len(matrix), k))]) for matrix in (B1, D11))
        D21 = np.hstack([D21, size * np.eye(k)])
    return GeneralisedPlant(
        A=plant.A, B1=B1, B2=plant.B2, C1=C1, C2=plant.C2, D11=D11, D12=D12, D21=D21
    )


def _full(D: Floats) -> bool:
    sizes = np.linalg.svd(D, compute_uv=False)
    return len(D) >= D.shape[1] and bool(sizes[-1] > LITTLE * max(float(sizes[0]), 1e-300))


def _central(plant: GeneralisedPlant, gamma: float) -> StateSpace | None:
    """Return the central controller of a norm below gamma; None where a condition fails."""
    from scipy.linalg import solve_continuous_are

    # z, w, u and y in coordinates with D12 = [0; I], D21 = [0, I].
    m, k = plant.D12.shape[1], plant.D21.shape[0]
    U, sizes_u, Vu = np.linalg.svd(plant.D12)
    Y, sizes_y, Vy = np.linalg.svd(plant.D21)
    z, w = np.roll(U, -m, axis=1), np.roll(Vy.T, -k, axis=1)
    to_u, from_y = Vu.T / sizes_u, (Y / sizes_y).T
    A, B1, B2 = plant.A, plant.B1 @ w, plant.B2 @ to_u
    C1, C2, D11 = z.T @ plant.C1, from_y @ plant.C2, z.T @ plant.D11 @ w
    D12, D21 = z.T @ plant.D12 @ to_u, from_y @ plant.D21 @ w
    (p, q), n = D11.shape, len(A)
    B, C = np.hstack([B1, B2]), np.vstack([C1, C2])
    row, column = np.hstack([D11, D12]), np.vstack([D11, D21])
    R = row.T @ row - np.diag([gamma**2] * q + [0.0] * m)
    Rt = column @ column.T - np.diag([gamma**2] * p + [0.0] * k)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            X = solve_continuous_are(A, B, C1.T @ C1, R, s=C1.T @ row)
            Yi = solve_continuous_are(A.T, C.T, B1 @ B1.T, Rt, s=B1 @ column.T)
            F = -np.linalg.solve(R, row.T @ C1 + B.T @ X)
            L = -np.linalg.solve(Rt, (B1 @ column.T + Yi @ C.T).T).T
            Z = np.linalg.inv(np.eye(n) - Yi @ X / gamma**2)
            top, unmeasured_columns = p - m, q - k
            D1111, D1112 = D11[:top, :unmeasured_columns], D11[:top, unmeasured_columns:]
            D1121, D1122 = D11[top:, :unmeasured_columns], D11[top:, unmeasured_columns:]
            S = np.linalg.inv(gamma**2 * np.eye(top) - D1111 @ D1111.T)
            Q = np.linalg.inv(gamma**2 * np.eye(unmeasured_columns) - D1111.T @ D1111)
            Dk = -D1121 @ D1111.T @ S @ D1112 - D1122
            np.linalg.cholesky(np.eye(m) - D1121 @ Q @ D1121.T)
            np.linalg.cholesky(np.eye(k) - D1112.T @ S @ D1112)
    except (np.linalg.LinAlgError, ValueError):
        return None
    if (
        np.linalg.eigvalsh(X)[0] < -1e-8 * abs(X).max()
        or np.abs(np.linalg.eigvals(X @ Yi)).max() >= gamma**2
    ):
        return None
    # The factors of D12-hat and D21-hat cancel in the central controller.
    measured = -(C2 + F[unmeasured_columns:q])
    Bk = -Z @ L[:, p:] + Z @ (B2 + L[:, top:p]) @ Dk
    Ck = F[q:] + Dk @ measured
    Ak = A + B @ F + Bk @ measured
    controller = StateSpace(Ak, Bk @ from_y, to_u @ Ck, to_u @ Dk @ from_y)
    return controller if all(np.isfinite(M).all() for M in (Ak, Bk, Ck, Dk)) else None


def without_fast_poles(controller: StateSpace) -> Iterator[StateSpace]:
    """Yield the controller with its fastest modes replaced by their gains, the most of them first.

    Modes that are as fast as one another are replaced together.
    """
    from scipy.linalg import schur, solve_sylvester

    speeds = np.sort(np.abs(np.linalg.eigvals(controller.A)))
    for slow_modes in range(controller.order):
        slow = float(speeds[slow_modes - 1]) if slow_modes else 0.0
        if not speeds[slow_modes] > 10.0 * slow:
            continue
        middle = float(np.sqrt(max(slow, 1e-300) * speeds[slow_modes]))

        def stays(re: float, im: float, middle: float = middle) -> bool:
            return bool(np.hypot(re, im) <= middle)

        S, Z, _ = schur(np.asarray(controller.A), output="real", sort=stays)
        X: Floats = np.zeros((slow_modes, controller.order - slow_modes))
        if slow_modes:
            X = np.asarray(
                solve_sylvester(
                    S[:slow_modes, :slow_modes],
                    -S[slow_modes:, slow_modes:],
                    -S[:slow_modes, slow_modes:],
                ),
                np.float64,
            )
        B, C = Z.T @ controller.B, controller.C @ Z
        B_slow, C_fast = (
            B[:slow_modes] - X @ B[slow_modes:],
            C[:, slow_modes:] + C[:, :slow_modes] @ X,
        )
        D = controller.D - C_fast @ np.linalg.solve(S[slow_modes:, slow_modes:], B[slow_modes:])
        yield in_even_states(StateSpace(S[:slow_modes, :slow_modes], B_slow, C[:, :slow_modes], D))


def in_even_states(controller: StateSpace) -> StateSpace:
    """Return the controller in states whose rows and columns are of one size, by powers of two.

    Source: Osborne (1960), Journal of the ACM 7.
    """
    A, B, C = controller.A.copy(), controller.B.copy(), controller.C.copy()
    for k in [*range(len(A))] * ROUNDS:
        other_states = np.arange(len(A)) != k
        row = np.linalg.norm([*A[k, other_states], *B[k]])
        column = np.linalg.norm([*A[other_states, k], *C[:, k]])
        if not (row > 0 and column > 0):
            continue
        t = float(nearest_power(np.sqrt(row / column)))
        A[k], B[k] = A[k] / t, B[k] / t
        A[:, k], C[:, k] = A[:, k] * t, C[:, k] * t
    return StateSpace(A, B, C, controller.D)


def entry_size(controller: StateSpace) -> float:
    """Return the largest entry."""
    matrices = (controller.A, controller.B, controller.C, controller.D)
    return max(float(np.abs(matrix).max(initial=0.0)) for matrix in matrices)


def plain_controller(plant: GeneralisedPlant, T: Floats) -> StateSpace | None:
    """Return a regulator with a filter that weigh all states of x = T xhat alike; None if none."""
    from scipy.linalg import solve_continuous_are

    scaled_plant = plant.in_states(T)
    n, m, k = len(scaled_plant.A), scaled_plant.B2.shape[1], len(scaled_plant.C2)
    u, y = np.linalg.norm(scaled_plant.B2, 2) or 1.0, np.linalg.norm(scaled_plant.C2, 2) or 1.0
    try:
        P = solve_continuous_are(scaled_plant.A, scaled_plant.B2, np.eye(n), u * np.eye(m))
        S = solve_continuous_are(scaled_plant.A.T, scaled_plant.C2.T, np.eye(n), y * np.eye(k))
    except (np.linalg.LinAlgError, ValueError):
        return None
    K, L = scaled_plant.B2.T @ P / u, S @ scaled_plant.C2.T / y
    law = StateSpace(
        scaled_plant.A - scaled_plant.B2 @ K - L @ scaled_plant.C2, L, -K, np.zeros((m, k))
    )
    return in_even_states(law) if np.isfinite(loop_norm(plant, law)) else None


def rounded_rows(controller: StateSpace) -> StateSpace:
    """Return the controller without entries that are rounding beside the others of their row."""
    n = controller.order
    all_rows = np.block([[controller.A, controller.B], [controller.C, controller.D]])
    row_sizes = np.abs(all_rows).max(axis=1, keepdims=True)
    all_rows = np.where(np.abs(all_rows) < ROUNDING * row_sizes, 0.0, all_rows)
    return StateSpace(all_rows[:n, :n], all_rows[:n, n:], all_rows[n:, :n], all_rows[n:, n:])

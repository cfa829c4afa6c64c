"""Limits on how fast the inputs move: the input as a state, exact.

With u' = v (or u+ = u + v) a state of the model, limits on u are limits on states, limits on v are
input limits, and nothing is lost; the law is dynamic.  ``input_rate_bound`` gives the rates that a
design without these states needs.
"""

from __future__ import annotations

import numpy as np

from takagi.lmi.argument_checks import input_stack, vertex_stack
from takagi.models import TSModel
from takagi.models.errors import ModelError


def with_input_states(model: TSModel) -> TSModel:
    """Return the model with its inputs as states: u' = v, or u+ = u + v in discrete time.

    The new inputs v are the rates (in one sample: the changes) of the old ones, which are the
    last states.  In discrete time the change acts at once, x+ = A x + B (u + v), so that nothing
    is delayed.  A limit on u is then a ``state_box``, one on v an ``input_limit``.

    Raises
    ------
    ModelError : a model without inputs.
    """
    A, B = vertex_stack(model), np.asarray(model.B)
    r, n, m = B.shape
    if m == 0:
        raise ModelError(f"model {model.name!r} has no inputs; there is nothing to make a state")
    input_stack(model, A)
    discrete = model.sample_time is not None
    one = np.broadcast_to(np.eye(m), (r, m, m))
    held = one if discrete else 0 * one
    rest = np.zeros((r, m, n))
    measured, disturbed = model.C.shape[1] > 0, model.E.shape[2] > 0
    return TSModel(
        np.block([[A, B], [rest, held]]),
        np.concatenate([B if discrete else 0 * B, one], axis=1),
        C=np.concatenate([model.C, model.D], axis=2) if measured else None,
        D=(model.D if discrete else 0 * model.D) if measured else None,
        E=np.concatenate([model.E, np.zeros((r, m, model.E.shape[2]))], axis=1)
        if disturbed
        else None,
        states=(*model.states, *model.inputs),
        inputs=[_moving(name, discrete) for name in model.inputs],
        outputs=model.outputs if measured else None,
        disturbances=model.disturbances if disturbed else None,
        premises=model.premises,
        rules=model.rules,
        box=model.box,
        sample_time=model.sample_time,
        name=f"{model.name}, inputs as states" if model.name else "inputs as states",
        source=model.source,
    )


def _moving(name: str, discrete: bool) -> str:
    """Return the name of an input's rate or change, with its unit."""
    if discrete:
        return f"change of {name}"
    if name.endswith("[-]"):
        return f"rate of {name[:-3]}[1/s]"
    return f"rate of {name[:-1]}/s]" if name.endswith("]") else f"rate of {name}"

r"""Plants, models and laws as systems of python-control, to draw, connect and simulate with.

Linearised at a point (x0, u0, w0), with f0 = x' there,

    A = M^-1 (df/dx - [dM/dx_k f0]_k),   B = M^-1 df/du,   E = M^-1 df/dw,

which is the Jacobian of M^-1 f.  Inputs of the system are the plant's, then its disturbances.  A
turbine has its drive, tower and torsion besides; a law is connected with either.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.laws.pdc import PdcLaw
from takagi.models.laws.protocol import Command, Law, Measurement, ProgramState, SampledLaw
from takagi.models.plant.plant import Output, Plant, explicit_rows, numeric
from takagi.models.simulation.turbine_plant import SimulatedTurbine, design_plant, plant_rate
from takagi.models.ts.model import TSModel
from takagi.models.turbine.data import Turbine

if TYPE_CHECKING:
    import control
    import sympy as sp

INPUTS = ["torque", "pitch_reference", "wind"]
# Step of the differences, as a share of the state's or input's size.
STEP = 1e-5


def turbine_system(plant: SimulatedTurbine) -> control.NonlinearIOSystem:
    """Return the turbine's equations; inputs torque [N m], pitch_reference [rad], wind [m/s].

    Outputs are the states.  The drive holds its reference and its rate within their limits.
    """
    import control

    rate = plant_rate(plant)
    names = signal_names(plant.state_names)

    def update(t: float, x: Floats, u: Floats, params: Any) -> Floats:
        torque, reference, wind = map(float, u)
        return rate(np.asarray(x, dtype=np.float64), torque, reference, wind)

    return control.nlsys(
        update, None, name="turbine", states=names, inputs=INPUTS, outputs=names, dt=0
    )


def turbine_statespace(plant: SimulatedTurbine, wind: float) -> control.StateSpace:
    """Return the linear system at the trim of a wind [m/s], by differences of second order.

    Pitch and its reference are moved upwards alone: below rated wind they lie at the end of their
    range, where the drive holds them.

    Raises
    ------
    ModelError : a wind that is not within cut-in and cut-out.
    """
    import control

    turbine = plant.turbine
    if not turbine.cut_in <= wind <= turbine.cut_out:
        raise ModelError(
            f"at: wind = {wind!r} was given; {turbine.cut_in:g} to {turbine.cut_out:g} m/s is "
            "needed"
        )
    derivative = plant_rate(plant)
    state, point = plant.initial_state(wind)
    names = signal_names(plant.state_names)
    n = len(names)
    centre = np.array([*state, point.torque, point.pitch, wind])

    def rate(state_and_inputs: Floats) -> Floats:
        torque, reference, v = map(float, state_and_inputs[n:])
        return derivative(state_and_inputs[:n], torque, reference, v)

    J = np.zeros((n, n + 3))
    for k, name in enumerate([*names, *INPUTS]):
        step = np.zeros(n + 3)
        step[k] = STEP * max(1.0, abs(centre[k]))
        if "pitch" in name:
            two, single = rate(centre + 2 * step), rate(centre + step)
            J[:, k] = (4 * single - two - 3 * rate(centre)) / (2 * step[k])
        else:
            J[:, k] = (rate(centre + step) - rate(centre - step)) / (2 * step[k])
    return control.ss(
        J[:, :n], J[:, n:], np.eye(n), np.zeros((n, 3)), states=names, inputs=INPUTS, outputs=names
    )


def signal_names(labels: Iterable[str]) -> list[str]:
    """Return labels such as ``rotor speed [rad/s]`` as ``rotor_speed``.

    python-control has a meaning for a dot in a name, and none for units.
    """
    return [re.sub(r"\W+", "_", label.split(" [")[0]).strip("_") for label in labels]


def statespace(
    model: Plant | TSModel | Turbine | SimulatedTurbine, *, at: Mapping[str, float] | None = None
) -> control.StateSpace:
    """Return the linear system at an operating point, with named states, inputs and outputs.

    Parameters
    ----------
    model : a plant (``load_plant``), a Takagi-Sugeno model, or a turbine: the plant of its design,
        or a ``SimulatedTurbine`` with drive, tower and torsion.
    at : values of states, inputs and disturbances by name, SI; those left out are at their rest.
        Of a Takagi-Sugeno model they are deviations from it, as its states are.  Of a turbine it
        is the wind alone, whose trim is taken: ``at={"wind": 12.0}``.

    Inputs are those of the model, then its disturbances.  Outputs are those of the model; of a
    plant all states come first, and a model without outputs gives its states.  In discrete time the
    system has the model's sample time.

    Raises
    ------
    ModelError : a name that the model does not have, or a point where it has no value.
    """
    import control

    if isinstance(model, Turbine | SimulatedTurbine):
        point = dict(at or {})
        if set(point) != {"wind"}:
            raise ModelError(
                f"at = {point} was given; a turbine needs its wind alone, at={{'wind': 12.0}}"
            )
        return turbine_statespace(_simulated(model), float(point["wind"]))
    if isinstance(model, Plant):
        A, B, C, D = _linearised(model, at or {})
        outputs = _plant_outputs(model)
        states = [variable.name for variable in model.states]
        inputs = [variable.name for variable in (*model.inputs, *model.disturbances)]
    else:
        A, B, C, D = _blended(model, at or {})
        states = signal_names(model.states)
        inputs = signal_names((*model.inputs, *model.disturbances))
        outputs = signal_names(model.outputs) if len(model.outputs) else states
    step = model.sample_time
    return control.ss(
        A, B, C, D, 0 if step is None else step, states=states, inputs=inputs, outputs=outputs
    )


def nonlinear_system(plant: Plant | Turbine | SimulatedTurbine) -> control.NonlinearIOSystem:
    """Return the plant's own equations as a nonlinear system, SI units.

    Of a turbine see ``turbine_system``: the plant of its design, or all that a ``SimulatedTurbine``
    has.

    States, inputs and disturbances have the plant's names; inputs come first, then disturbances.
    Outputs are all states, then the plant's outputs.  ``control.input_output_response`` and
    ``control.interconnect`` take it.

    Raises
    ------
    ModelError : a plant behind a blend, whose input is the rate of an effort.
    """
    import control

    if isinstance(plant, Turbine | SimulatedTurbine):
        return turbine_system(_simulated(plant))
    if plant.blending is not None:
        raise ModelError(
            f"{plant.name}: its two actuators stand behind a blend; give the plant as it was "
            "written, plant.blending.plant"
        )
    symbols = [variable.symbol for variable in plant.variables]
    rate = explicit_rows(plant, symbols, plant.rationals)
    read = numeric((y.expression for y in _own_outputs(plant)), symbols, plant.rationals)

    def update(t: float, x: Floats, u: Floats, params: Any) -> Floats:
        return rate(*map(float, x), *map(float, u))

    def output(t: float, x: Floats, u: Floats, params: Any) -> Floats:
        return np.concatenate([x, read(*map(float, x), *map(float, u))])

    return control.nlsys(
        update,
        output,
        name=signal_names([plant.name])[0] or "plant",
        states=[quantity.name for quantity in plant.states],
        inputs=[quantity.name for quantity in (*plant.inputs, *plant.disturbances)],
        outputs=_plant_outputs(plant),
        dt=0 if plant.sample_time is None else plant.sample_time,
    )


def _simulated(turbine: Turbine | SimulatedTurbine) -> SimulatedTurbine:
    return turbine if isinstance(turbine, SimulatedTurbine) else design_plant(turbine)


def _own_outputs(plant: Plant) -> list[Output]:
    """Return the outputs that are not a state of the same name, which is an output anyway."""
    states = {quantity.name: quantity.symbol for quantity in plant.states}
    return [
        quantity for quantity in plant.outputs if states.get(quantity.name) != quantity.expression
    ]


def _plant_outputs(plant: Plant) -> list[str]:
    """Return states, then outputs; an output that is called as a state gets ``_output``."""
    states = [quantity.name for quantity in plant.states]
    return states + [
        f"{quantity.name}_output" if quantity.name in states else quantity.name
        for quantity in _own_outputs(plant)
    ]


def _linearised(plant: Plant, at: Mapping[str, float]) -> tuple[Floats, Floats, Floats, Floats]:
    import sympy as sp

    rest_values = {quantity.name: float(quantity.rest) for quantity in plant.variables}
    _require_names(at, rest_values)
    point = np.array([(rest_values | dict(at))[quantity.name] for quantity in plant.variables])
    n = len(plant.states)
    symbols = [variable.symbol for variable in plant.variables]
    f = sp.Matrix(list(plant.equations))
    outputs = sp.Matrix([quantity.expression for quantity in _own_outputs(plant)])

    def there(matrix: sp.Matrix) -> Floats:
        return numeric(matrix, symbols, plant.rationals)(*map(float, point)).reshape(matrix.shape)

    J = there(f.jacobian(symbols))
    if plant.mass is not None:
        M = there(plant.mass)
        rate = np.linalg.solve(M, there(f).ravel())
        for k in range(n):
            J[:, k] -= there(plant.mass.diff(symbols[k])) @ rate
        J = np.asarray(np.linalg.solve(M, J), dtype=np.float64)
    read = there(outputs.jacobian(symbols)) if len(outputs) else np.zeros((0, len(point)))
    if not (np.all(np.isfinite(J)) and np.all(np.isfinite(read))):
        raise ModelError(f"{plant.name} has no linearisation at {rest_values | dict(at)}")
    C = np.vstack([np.eye(n), read[:, :n]])
    D = np.vstack([np.zeros((n, len(point) - n)), read[:, n:]])
    return J[:, :n], J[:, n:], C, D


def _blended(model: TSModel, at: Mapping[str, float]) -> tuple[Floats, Floats, Floats, Floats]:
    labels = (*model.states, *model.inputs, *model.disturbances)
    signals = dict.fromkeys((label.split(" [")[0] for label in labels), 0.0)
    _require_names(at, signals)
    if model.premises:
        h = model.memberships(model.premise_values(**(signals | dict(at))))
    elif len(model.rules) == 1:
        h = np.ones(1)
    else:
        raise ModelError(
            f"{model.name}: its vertices have no premises, so no point has a linear system; take "
            "one vertex, control.ss(model.A[0], model.B[0], ...)"
        )

    def mixed(matrices: Floats) -> Floats:
        return np.asarray(np.tensordot(h, matrices, axes=1), dtype=np.float64)

    A, B = mixed(model.A), np.hstack([mixed(model.B), mixed(model.E)])
    if not len(model.outputs):
        return A, B, np.eye(len(A)), np.zeros((len(A), B.shape[1]))
    C, D = mixed(model.C), mixed(model.D)
    return A, B, C, np.hstack([D, np.zeros((len(C), B.shape[1] - D.shape[1]))])


def _require_names(point: Mapping[str, float], names: Mapping[str, float]) -> None:
    for name, value in point.items():
        if name not in names:
            raise ModelError(
                f"at: {name!r} was given; the model has {', '.join(names)}"
                f"{did_you_mean(name, list(names))}"
            )
        if not np.isfinite(value):
            raise ModelError(f"at: {name} = {value!r} was given; a finite value is needed")


def law_system(law: PdcLaw | Law | SampledLaw) -> control.NonlinearIOSystem:
    """Return a law as a nonlinear system, SI units.

    - ``PdcLaw``: no states; its inputs are the plant's states, its outputs the plant's inputs.
    - ``Law`` of a turbine: the law's states; inputs rotor_speed, pitch, wind_estimate; outputs
      torque, pitch_reference.
    - ``SampledLaw``: the law's states, torque_sent, pitch_sent; inputs and outputs as ``Law``.

    A ``SampledLaw``, and a ``PdcLaw`` in discrete time, are systems in discrete time.

    Raises
    ------
    ModelError : a law behind a blend, whose command is the rate of an effort.
    """
    if isinstance(law, PdcLaw):
        return _pdc(law)
    return _turbine(law)


def _pdc(law: PdcLaw) -> control.NonlinearIOSystem:
    import control

    if law.blend is not None:
        raise ModelError(
            f"law {law.name!r} commands the rate of an effort that two actuators share; simulate "
            "it with `takagi simulate`"
        )

    def output(t: float, x: Floats, u: Floats, params: Any) -> Floats:
        return law.sent(u)

    return control.nlsys(
        None,
        output,
        name="law",
        inputs=signal_names(law.model.states),
        outputs=signal_names(law.model.inputs),
        dt=0 if law.sample_time is None else law.sample_time,
    )


def _turbine(law: Law | SampledLaw) -> control.NonlinearIOSystem:
    import control

    states, sample_time = signal_names(law.state_names), 0.0
    if isinstance(law, SampledLaw):
        states, sample_time = [*states, "torque_sent", "pitch_sent"], law.sample_time

    def stepped(x: Floats, u: Floats) -> tuple[Floats, Floats]:
        """Return the command, and the states' rate or the next states."""
        seen = Measurement(*map(float, u))
        if not isinstance(law, SampledLaw):
            return np.array(law.command(x, seen)), law.state_rate(x, seen)
        before = Command(*map(float, x[-2:]))
        sent, later = law.step(ProgramState(np.asarray(x[:-2], dtype=np.float64), before), seen)
        return np.array(sent), np.concatenate([later.law_state, later.sent])

    return control.nlsys(
        lambda t, x, u, params: stepped(x, u)[1],
        lambda t, x, u, params: stepped(x, u)[0],
        name="law",
        states=states,
        inputs=list(Measurement._fields),
        outputs=["torque", "pitch_reference"],
        dt=sample_time,
    )

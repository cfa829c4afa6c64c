"""A law as a system of python-control, to be connected with a plant."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.control_systems.turbine_systems import signal_names
from takagi.models.errors import ModelError
from takagi.models.laws.pdc import PdcLaw
from takagi.models.laws.protocol import Command, Law, Measurement
from takagi.models.laws.sampled import ProgramState, SampledLaw

if TYPE_CHECKING:
    import control


def law_system(law: PdcLaw | Law | SampledLaw) -> control.NonlinearIOSystem:
    """Return a law as a nonlinear system, SI units.

    ==================  ============================  ==========================  ================
    law                 states                        inputs                      outputs
    ==================  ============================  ==========================  ================
    ``PdcLaw``          none                          the plant's states          its inputs
    of a turbine        the law's                     rotor_speed, pitch,         torque,
                                                      wind_estimate               pitch_reference
    ``SampledLaw``      the law's, torque_sent,       the same                    the same
                        pitch_sent
    ==================  ============================  ==========================  ================

    A ``SampledLaw``, and a ``PdcLaw`` in discrete time, are systems in discrete time.

    Raises
    ------
    ModelError : a law behind a blend, whose command is the rate of an effort.
    """
    if isinstance(law, PdcLaw):
        return _pdc(law)
    return _sampled(law) if isinstance(law, SampledLaw) else _turbine(law)


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


def _turbine(law: Law) -> control.NonlinearIOSystem:
    import control

    def update(t: float, x: Floats, u: Floats, params: Any) -> Floats:
        return law.state_rate(x, Measurement(*map(float, u)))

    def output(t: float, x: Floats, u: Floats, params: Any) -> Floats:
        return np.array(law.command(x, Measurement(*map(float, u))))

    return control.nlsys(
        update,
        output,
        name="law",
        states=signal_names(law.state_names),
        inputs=list(Measurement._fields),
        outputs=["torque", "pitch_reference"],
        dt=0,
    )


def _sampled(law: SampledLaw) -> control.NonlinearIOSystem:
    import control

    def program(x: Floats) -> ProgramState:
        return ProgramState(np.asarray(x[:-2], dtype=np.float64), Command(*map(float, x[-2:])))

    def update(t: float, x: Floats, u: Floats, params: Any) -> Floats:
        _, later = law.step(program(x), Measurement(*map(float, u)))
        return np.concatenate([later.law_state, later.sent])

    def output(t: float, x: Floats, u: Floats, params: Any) -> Floats:
        sent, _ = law.step(program(x), Measurement(*map(float, u)))
        return np.array(sent)

    return control.nlsys(
        update,
        output,
        name="law",
        states=[*signal_names(law.state_names), "torque_sent", "pitch_sent"],
        inputs=list(Measurement._fields),
        outputs=["torque", "pitch_reference"],
        dt=law.sample_time,
    )

"""The Kalman filter of the wind against the one of Stone Soup (dstl), on one of OpenFAST's records.

    pip install stonesoup
    python benchmarks/wind_kalman_peer.py RUNS/q_base_15_1 WINDS

Stone Soup's filter is in discrete time and takes its Jacobian by differences of its own.
"""

from __future__ import annotations

import sys
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
from stonesoup.base import Property
from stonesoup.models.measurement.linear import LinearGaussian
from stonesoup.models.transition.nonlinear import GaussianTransitionModel
from stonesoup.predictor.kalman import ExtendedKalmanPredictor
from stonesoup.types.detection import Detection
from stonesoup.types.hypothesis import SingleHypothesis
from stonesoup.types.state import GaussianState
from stonesoup.updater.kalman import ExtendedKalmanUpdater
from wind_estimators import TURBINE, estimate, judged, kalman, record

from takagi.models.turbine import rotor_torque

BANDWIDTH = 2.0


class Rotor(GaussianTransitionModel):  # type: ignore[misc,unused-ignore]
    """One Euler step of (speed, wind) under the pitch and torque that are read."""

    step: float = Property()
    noise: float = Property()
    reading: Any = Property(default=(0.0, 0.0))
    ndim_state = 2

    def function(self, state: Any, **_: Any) -> Any:
        """Return the states after the step, a column for each point."""
        speed, wind = np.asarray(state.state_vector, dtype=float)
        pitch, torque = self.reading
        drive = rotor_torque(TURBINE, speed, pitch, wind, clip=True) - TURBINE.gear_ratio * torque
        after = np.stack([speed + self.step * drive / TURBINE.inertia, wind])
        return type(state.state_vector)(after)

    def covar(self, **_: Any) -> Any:
        """Return the noise of one step."""
        return np.diag([0.0, self.noise * self.step])


def main() -> None:
    """Print rms, bias and lag of both, and the rms of their difference."""
    rows = record(Path(sys.argv[1]), Path(sys.argv[2]))
    own, step = kalman(BANDWIDTH), float(rows["time"][1] - rows["time"][0])
    model = Rotor(step=step, noise=own.wind_noise)
    sensor = LinearGaussian(2, (0,), np.array([[own.speed_noise / step]]))
    predictor, updater = ExtendedKalmanPredictor(model), ExtendedKalmanUpdater(sensor)
    now = datetime(2000, 1, 1)
    first = own.initial_state(float(rows["speed"][0]), float(rows["wind"][0]))
    covariance = np.array([[first[2], first[3]], [first[3], first[4]]])
    state = GaussianState(first[:2].reshape(2, 1), covariance, timestamp=now)
    found = []
    for speed, pitch, torque in zip(rows["speed"], rows["pitch"], rows["torque"], strict=True):
        found.append(float(state.state_vector[1, 0]))
        read = Detection(np.array([[speed]]), timestamp=now, measurement_model=sensor)
        state = updater.update(SingleHypothesis(predictor.predict(state, timestamp=now), read))
        model.reading, now = (pitch, torque), now + timedelta(seconds=step)
    peer, ours = np.array(found), estimate(own, rows)
    late = rows["time"] >= 60
    print("takagi     {:.4f} {:+.4f} {:.3f}".format(*judged(ours, rows)))
    print("Stone Soup {:.4f} {:+.4f} {:.3f}".format(*judged(peer, rows)))
    print(f"rms of their difference {np.sqrt(np.mean((peer - ours)[late] ** 2)):.4f} m/s")


if __name__ == "__main__":
    main()

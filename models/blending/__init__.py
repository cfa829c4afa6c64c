"""Two actuators that share one effort, handed over by a ramp, for any plant."""

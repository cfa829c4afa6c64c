"""Output feedback of fixed order: few states of the controller, or none."""

"""From a model, a plant or a turbine with its gains to claims; the checker decides about each."""

"""Plants, models and laws as systems of python-control, to draw, connect and simulate with.

plant_systems   the linearisation of a plant or model, and the nonlinear plant
turbine_systems the same of a turbine, with drive, tower and torsion; names of signals
law_systems     a law, to be connected with a plant
"""

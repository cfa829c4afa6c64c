"""Wind turbines: figures with their sources, aerodynamics, trim, regional models, observer."""

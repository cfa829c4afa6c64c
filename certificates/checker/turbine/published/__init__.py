"""Claims about a turbine with a published law (kind ``paper-loop``), at constant winds."""

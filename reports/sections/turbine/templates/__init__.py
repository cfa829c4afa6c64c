"""Templates of the report of a turbine, one a section."""

"""Templates of the report of a plant, one a section."""

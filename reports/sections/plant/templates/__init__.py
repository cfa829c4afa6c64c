"""Templates of the report and the appendix of a plant."""

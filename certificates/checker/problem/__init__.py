"""Claims about a conic problem that is not about a loop: solutions, bounds, contradictions."""

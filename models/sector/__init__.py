"""Symbolic sector nonlinearity: from equations of motion to an exact Takagi-Sugeno model."""

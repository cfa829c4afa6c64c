"""Robustness of linear loops: classical and disk margins, and the turbine's loops at a trim."""

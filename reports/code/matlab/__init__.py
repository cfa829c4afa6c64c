"""MATLAB, Simulink and Octave: the law as functions, and its numbers as a struct."""

"""MATLAB, Simulink and Octave: the law as functions, and its numbers as a struct.

step_function   ``W_step.m`` and ``W_start.m``: one sample of the law
struct_file     ``W.mat``: gains, vertices, tables, P and sample time
target          the target `mat`
"""

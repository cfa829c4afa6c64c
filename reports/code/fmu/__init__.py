"""The law as a functional mock-up unit (FMI 3.0 and 2.0, co-simulation).

runner.h, fmi3.c, fmi2.c: time, samples and the functions of the standards, the same in every FMU.
"""

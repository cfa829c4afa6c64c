"""The law as a functional mock-up unit (FMI 3.0 and 2.0, co-simulation).

runner.h, fmi3.c, fmi2.c  time, samples and the functions of the standards: the same in every FMU
model_source     model.h, the part that differs from FMU to FMU
description      modelDescription.xml and buildDescription.xml, units as exponents
archive          the FMU file, with a library for this platform
target           the files that `takagi export --to fmu` writes
"""

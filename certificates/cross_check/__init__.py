"""A second checker, written independently, which uses FLINT.

    kernel/     the file, exact matrices, and the conditions to decide
    loop/       claims about the loop of model and gains
    plant/      a plant is contained in its model
    turbine/    claims about a turbine's loop
    opinion     its verdicts on a file; ``audit.two_checkers`` compares both checkers

It imports FLINT and the standard library alone: an error in the first checker, in the models or in
the solver cannot be repeated here by sharing their code.
"""

"""The law of a gain file as code that other tools run; every number is a decimal of the file.

formula             a formula of a program as a tree
controller_program  the programs of a gain file as one value, which every target reads
run                 that value run in Python: known answers for what is written
identifiers         names that a target's language can hold
fmu                 the law, and its closed loop, as functional mock-up units
certified_model     the plant of a gain file's certificate
targets             the targets of `takagi export`, and what each writes
tables              CSV
c                   C99
discon              the Bladed-style library around it
"""

"""The texts that verbs print on the terminal.

turbine_summary, plant_summary    the summary of a finished design
plant_set                         the proved set of a plant, in the units of its file
lines                             a heading with its text, broken into lines; a check's claims
files                             the files of a design; the reason where there is no design
trusted_lines                     files and lines of code that a verdict depends on
simulation_table                  the numbers of a simulation
"""

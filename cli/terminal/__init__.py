"""The texts that verbs print on the terminal.

turbine_summary, plant_summary    the summary of a finished design
plant_set                         the proved set of a plant, in the units of its file
files                             the files of a design; the reason where there is no design
claim_lines                       the result of a check, claim by claim; the code it depends on
simulation_table                  the numbers of a simulation
"""

"""What verbs print on the terminal.

turbine_summary, plant_summary    what a finished design says of itself
plant_set                         of the proved set, in the units of the plant's file
lines                             a word and its text, broken where lines end
files                             what it leaves in its folder; that there is none
claim_lines                       what a check found, claim by claim
trusted_lines                     the files and lines that a verdict ran through
simulation_table                  the numbers of a simulation
"""

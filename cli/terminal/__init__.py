"""What verbs print on the terminal.

turbine_summary, plant_summary    what a finished design says of itself
files                             what it leaves in its folder; that there is none
claim_lines                       what a check found, claim by claim
trusted_lines                     the files and lines that a verdict ran through
simulation_table                  the numbers of a simulation
"""

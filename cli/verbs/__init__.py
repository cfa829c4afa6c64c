"""One verb of the command line a file, of the verb's name.

design_plant, simulate_plant    the same verbs for a plant
simulate_campaign               random runs compared with what a certificate claims
sweep_maps                      the maps that `takagi sweep` can make: one line a law
"""

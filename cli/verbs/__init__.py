"""One verb of the command line a file, of the verb's name.

simulate_turbine, simulate_plant    what `takagi simulate` does with each kind of model
simulate_campaign                   random runs compared with what a certificate claims
"""

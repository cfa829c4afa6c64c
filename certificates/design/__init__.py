"""From a turbine or plant to gains, law and checked certificate.

design           the members of a finished design; the exception for no design
turbine/         the design of a turbine's controller
plant/           the design of a controller for any plant
given/           existing gains, read from their file
claim_summary    the claim about a turbine's loop in numbers, cell by cell
step_clock       measures and reports the time of each design step
"""

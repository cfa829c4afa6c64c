"""From a turbine or plant to gains, law and checked certificate.

design           what a finished design is, of a turbine or of a plant; that there is none
turbine/         the design of a turbine's controller
plant/           the design of a controller for any plant
given/           gains that exist already, read back from their file
claim_summary    the claim about a turbine's loop in numbers, cell by cell
step_clock       measures and reports the time of each design step
"""

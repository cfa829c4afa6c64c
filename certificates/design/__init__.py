"""From a turbine or plant to gains, law and checked certificate.

turbine/         the design of a turbine's controller
plant/           the design of a controller for any plant
given/           gains that exist already, read back from their file
claim_summary    what the claim about a turbine's loop says, cell by cell
step_clock       times the steps of a design, and tells of them
"""

"""From a turbine or plant to gains, law and checked certificate.

design           the members of a finished design; the exception for no design; the time of steps
turbine/         the design of a turbine's controller
plant/           the design of a controller for any plant
given/           existing gains, read from their file
"""

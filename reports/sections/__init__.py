"""The HTML reports: one room each, one section of the page a file.

turbine/           the report of a turbine's design
plant/             the report of a plant's design
reproducibility    how to check a certificate, and where everything comes from: both have it
"""

"""The HTML reports: one room each, one section of the page a file.

turbine/           the report of a turbine's design
plant/             the report of a plant's design
verdict            what both say first
premise_table      premises with their bounds
margin_table       margins of linear loops
reproducibility    how to check a certificate, and where everything comes from
"""

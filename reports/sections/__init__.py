"""The HTML reports: one folder for each, one file for each section of the page.

turbine/           the report of a turbine's design
plant/             the report of a plant's design
verdict            the verdict box, with which both begin
premise_table      premises with their bounds
margin_table       margins of linear loops
reproducibility    how to check a certificate; versions, hashes and settings
"""

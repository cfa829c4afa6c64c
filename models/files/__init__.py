"""What model files have in common.

toml_document        a TOML file that can say where in it something is wrong
units, turbine_units     units as text: of any plant, of a turbine file
csv_table, coefficient_table    tables from CSV
library              the models that come with the package, by name
"""

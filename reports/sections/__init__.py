"""The HTML reports: one folder for each, one file for each section of the page.

turbine/           the report of a turbine's design
shared             tables and sections that both reports have
plant/             the report of a plant's design
"""

"""The closed loop with a published law, enclosed cell by cell.

cells           interval families, one for each wind cell
vector_field    the loop's right-hand side on ranges with slopes
tables          trim tables, scheduled gains and figures that it is made of
"""

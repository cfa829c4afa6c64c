"""What a user can write down of a plant: equations, variables with units and ranges, tables.

plant      Plant, the value: M(x) x' = f(x, u, w), y = g(x, u, w), on a box
"""

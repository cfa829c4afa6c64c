"""The gain file ``gains.json``: one envelope, two bodies.

envelope   what every gain file has, its text, and its JSON Schema
turbine    the body of a turbine's file
plant      the body of a plant's file
"""

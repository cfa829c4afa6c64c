"""The gain file ``gains.json``.

schema     what it may contain, and its JSON Schema
turbine    how it is made from a turbine's design
plant      how it is made from a plant's design
"""

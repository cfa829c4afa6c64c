"""Claims about a turbine with the effort-sharing law.

The loop itself (kind ``coherent-loop``), and the claims that follow from it.
"""

"""The published multi-region laws (on the command line.

Paper): coupling filter, regional schedules, equilibria and linearisation.
"""

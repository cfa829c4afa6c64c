"""The turbine's loops.

coherent, coherent_*   the loop with one law for all winds
paper, paper_*         the loop with a law by regions
equilibrium, rest_count, *_rest    the equilibria of a loop at each wind
actuator_rates, wind_rate          claims that depend on the coherent loop's claim (earlier)
frozen_wake            the limit of pitch effectiveness, from a stated factor
interval_family        one inequality for a whole interval family;  spans: wind ranges
"""

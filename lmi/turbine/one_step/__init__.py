"""Gains of the effort-sharing law and the loop's quadratic functions, found together.

design                    gains at all winds and the functions, by small convex steps
condition, joint_step     the LMIs of one convex step; the solution of one step
iteration                 a sequence of steps; the loop is enclosed again after each step
loop_of_gains             the loop as a function of its gains, corner by corner
objective, value          weights of the objective; the values that given gains achieve
"""

"""Gains of the effort-sharing law and the loop's quadratic functions, found together.

design                    gains at all winds and the functions, by small convex steps
condition, joint_step     one convex step; steps that lose nothing
iteration                 from gains to better ones; each step is enclosed again
loop_of_gains             the loop as a function of its gains, corner by corner
loop_functions, value     the wind error tolerated, the states reached
objective, motion         what is made better; pitch and tower in turbulence, estimated
"""

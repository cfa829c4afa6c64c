"""The closed loop with the effort-sharing law as an interval family, one for each wind cell.

cells, loop_cell     the families; what one cell is enclosed on, and what that says
torque_slopes        ranges of the aerodynamic torque's slopes
law_interval         the law's tables between two wind nodes, exactly
moving_schedule      what a schedule wind that moves does to the loop
vertices             the matrices whose hull contains every loop of a cell
"""

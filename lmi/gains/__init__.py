"""Gains that are sought, one kind of question a room.

requirements/      what any of them may have to keep: limits, rates, regions, uncertainty
decay/             a decay rate: parallel distributed compensation, one relaxation after another
cost/              the least guaranteed quadratic cost
disturbance/       the least gain of energy, variance or peaks
attraction/        the largest region of attraction, with input limits and saturation
fuzzy/             with a Lyapunov function that depends on the memberships
structured/        with zeros, shared gains, outputs in the place of states
output_feedback/   controllers with states of their own, from measured outputs
observer         observers, also with premises that are not measured

The sums and their relaxations are in ``sums``.
"""

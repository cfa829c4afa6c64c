"""Dynamic output feedback: controllers with states of their own, by linear matrix inequalities.

One linear plant, least energy gain:

generalised_plant      plant and weights as one system, from w and u to z and y
condition              the LMIs of the energy gain; what makes them linear
controller             the controller of their unknowns; mixed sensitivity
fixed_order            a controller of given order, static ones among them, by descent on the norm
"""

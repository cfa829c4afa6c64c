"""Existing gains: the law of a gain file is read, to certify it or to run it.

turbine_law      a turbine's gains: the same commands, bit for bit, or a certificate for them
plant_gains      a plant's gains, for the same plant
kept_model       a plant's gains after the plant has changed
largest_change   weaker claims for them where the whole box is not proved
"""

"""Gains that exist already: the law of a gain file read back, to be certified or to be run.

turbine_law     a certificate for a turbine's gains
plant_gains     a plant's gains, for the plant that they were made for
kept_model      a plant's gains after the plant has changed
runnable_law    the law to run: the same commands, bit for bit
"""

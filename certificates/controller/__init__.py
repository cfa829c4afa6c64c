"""The members of a gain file other than the law.

content            the whole file, of a certificate or bound to a file that was given
plant_members      of a plant's file what model and law do not determine
removable_points   what replaces a premise where it is 0/0
"""

"""What a gain file says beside the law: made for a design, or read from a file that exists.

content             the gain file of a certificate as plain data, and the two bound together
given_file          the same for gains of a file
plant_members       what a plant's file says that model and law do not
removable_points    what stands in for a premise where it is 0/0
"""

"""The closed loop of any plant under a given feedback law, as secant matrices that contain its
motion.
"""

"""The closed loop of any plant under a given law, as secant matrices that contain its motion.

embedding      the front door: plant and law in, a family of matrices a cell out
feedback       a law u = v(x, w) in symbols, with amplitude limits
closed_loop    plant and law put together, with saturations as sectors
entries        entries of a secant matrix, and what they share
matrices       the families as values: factors, vertices, export
"""

"""The closed loop of a plant under a given law, enclosed by families of secant matrices.

embedding      computes a family of matrices for each cell from plant and law
feedback       a law u = v(x, w) in symbols, with amplitude limits
closed_loop    substitutes the law into the plant; saturations become sectors
entries        enclosures of the matrix entries; common factors of several entries
matrices       data types of the families: factors, vertices, export
"""

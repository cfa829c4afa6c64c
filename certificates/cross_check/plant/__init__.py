"""The second checker's claims that a plant is contained in its model.

expression, algebra    expressions as trees; whether two of them are the same function
slope, interval        their derivatives, and their ranges over boxes
plant                  a plant and its embedding, as trees, with exact vertices
model_loop             the loop that a model, of matrices or a plant, and gains make
embedding              the plant is the blend of its vertices
secant                 differences of the plant from its rest are blends
blend                  two actuators that share one effort make the plant's equations
"""

"""The second checker's claims that a plant is contained in its model.

expression, algebra    expressions as trees; whether two trees are the same function
slope, interval        derivatives of trees, and their ranges over boxes
plant                  a plant and its embedding, as trees, with exact vertices
model_loop             the loop of a model (of matrices, or of a plant) with gains
embedding              claim: the plant is the blend of its vertices
secant                 claim: the plant's deviation from rest is a blend of its vertices
blend                  claim: two actuators that share one effort give the plant's equations
"""

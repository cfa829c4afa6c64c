"""The second checker's claims that a plant is contained in its model.

expression, algebra    expressions as trees; whether two trees are the same function
slope, interval        derivatives of trees, and their ranges over boxes
plant                  a plant and its embedding, as trees, with exact vertices
identity               whether a tree is 0 everywhere;  references: integrals that a law computes
model_loop             the loop of a model (of matrices, or of a plant) with gains
embedding              claim: the plant is the blend of its vertices
secant                 claim: the plant's deviation from rest is a blend of its vertices
tracking               claim: an output converges to its reference
blend                  claim: two actuators that share one effort give the plant's equations
"""

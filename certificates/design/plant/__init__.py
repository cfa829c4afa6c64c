"""The design of a controller for any plant.

result          the finished design
design          how it is made: model, gains as they are emitted, certificate
gains           what is asked, as a question to the solver layer
secant_model    a model of slopes, for gains that need no measured premise
blend_regions   gains of a plant behind a blend, region by region
"""

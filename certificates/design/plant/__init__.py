"""The design of a controller for any plant.

result          the finished design
design          how it is made: model, gains as they are emitted, certificate
gains           what is asked, as a question to the solver layer; gains as short decimals
wishes          efforts, rates and starts in numbers, where the plant's file leaves them open
many_rules      which gains are sought where there are many rules; how long that takes
plain_words     messages in the words of the plant's file; which requirement excludes gains
secant_model    a model of slopes, for gains that need no measured premise
observed_design a law with measured outputs: gains, observer, and the proof of both together
tracking_gains  gains with integral action
blend_regions   gains of a plant behind a blend, region by region
"""

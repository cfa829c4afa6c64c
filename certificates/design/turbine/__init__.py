"""The design of a turbine's controller.

settings               the requirements, and their checks before the long work begins
result                 the finished design, and its claim in numbers
design                 makes it: models, gains, law, observer, certificate, gain file
effort_sharing_gains   gains of the effort-sharing law and the candidate of its claim
published_law          models and gains of each region; a design with a published law
scale                  settings for a turbine of another size
"""

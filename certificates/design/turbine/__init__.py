"""The design of a turbine's controller.

settings, result        what is asked for; the finished design
design                  from the one to the other: models, gains, law, observer, certificate
gain_file_members       what the gain file says that model and law do not
regions                 the model and the gains of each region by itself
effort_sharing_gains    gains of the effort-sharing law and the candidate of its claim
published_law           a design with a published law
scale                   settings for a turbine of another size
limits                  what is refused before the long work begins
"""

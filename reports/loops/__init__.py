"""A design's loops as numbers, read by sections, figures and appendix.

turbine_local        a turbine's law at its trims as linear feedback
plant_loop           plant, model, gains, proved function, largest commands on its ellipsoid
plant_local          poles and margins of a plant at rest and at the vertices
settling             when motions from the proved set are at rest
linear_quadratic     a regulator at rest to compare with
overshoot            how far a state gets beyond its start
plant_motion         the nonlinear plant under its law, in time
overlap_claims       what is proved of a published law, overlap by overlap
proved_kinds         which claims of a certificate are proved, and of which kinds
synthesis_summary    how the effort-sharing law's gains were found
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.loops.overlap_claims import gap_words as gap_words
    from takagi.reports.loops.overlap_claims import synthesis_words as synthesis_words
    from takagi.reports.loops.overlap_claims import wind_words as wind_words
    from takagi.reports.loops.plant_claims import half_widths as half_widths
    from takagi.reports.loops.plant_claims import overshoots as overshoots
    from takagi.reports.loops.plant_claims import settling_time as settling_time
    from takagi.reports.loops.plant_loop import PlantLoop as PlantLoop
    from takagi.reports.loops.plant_motion import motions as motions
    from takagi.reports.loops.plant_motion import plant_rate as plant_rate
    from takagi.reports.loops.plant_motion import starts as starts
    from takagi.reports.loops.plant_motion import uncertain_ends as uncertain_ends

__getattr__, __dir__ = lazy_names(__name__)

"""The design of a controller for any plant.

result          the finished design
design          how it is made: model, gains as they are emitted, certificate
gains           what is asked, as a question to the solver layer; gains as short decimals
obstacle        which requirement excludes gains, in a sentence
many_rules      which gains are sought where there are many rules; how long that takes:
                work_estimate
secant_model    a model of slopes, for gains that need no measured premise
observed_design  a law with measured outputs: gains, observer, and the proof of both together;
                what is asked of it: observer_question
blend_regions   gains of a plant behind a blend, region by region
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.design.plant.design import certify_filed as certify_filed
    from takagi.certificates.design.plant.design import certify_plant as certify_plant
    from takagi.certificates.design.plant.design import design_plant as design_plant
    from takagi.certificates.design.plant.gains import rounded_gains as rounded_gains
    from takagi.certificates.design.plant.many_rules import gain_choice as gain_choice
    from takagi.certificates.design.plant.many_rules import (
        gains_of_few_premises as gains_of_few_premises,
    )
    from takagi.certificates.design.plant.many_rules import model_of_premises as model_of_premises
    from takagi.certificates.design.plant.moderate_rate import reach_rates as reach_rates
    from takagi.certificates.design.plant.result import PlantDesign as PlantDesign
    from takagi.certificates.design.plant.work_estimate import effects as effects
    from takagi.certificates.design.plant.work_estimate import work_of as work_of

__getattr__, __dir__ = lazy_names(__name__)

r"""The LaTeX appendix of a design: derivation, law, theorem, LMIs, gains, certificate, margins.

    assembly                          the files of one appendix from its templates and figures
    design_files                      the appendix of a turbine, and of another plant
    turbine_figures                   a turbine's figures
    turbine, regional, schedule       plant, regional models, the effort-sharing law's tables
    blending                          the published coupling filter
    conditions, certificate           inequalities that were solved, claims that were proved
    robustness                        margins and responses at the trims
    plant_context                     the content of a plant's appendix
    environment, tex                  jinja2 for LaTeX; numbers, units and words as LaTeX

Both functions return ``appendix.tex``, which compiles alone, its body for ``\input`` into a paper,
and the figures.  Everything is typeset from the values that were solved and proved.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.appendix.design_files import appendix_files as appendix_files
    from takagi.reports.appendix.design_files import plant_appendix as plant_appendix

__getattr__, __dir__ = lazy_names(__name__)

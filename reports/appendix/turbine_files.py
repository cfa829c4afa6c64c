"""The LaTeX appendix of a turbine's design."""

from __future__ import annotations

from collections.abc import Callable

from takagi.certificates.design.turbine.result import TurbineDesign

Tell = Callable[[str], None]


def appendix_files(design: TurbineDesign, *, tell: Tell | None = None) -> dict[str, bytes | str]:
    """Return relative file name -> content of the LaTeX appendix of a design.

    ``appendix.tex`` compiles alone with pdflatex; ``appendix-body.tex`` is for ``\\input`` into a
    paper with the packages that its first lines name; ``figures/*.pdf`` are the figures.  The same
    design gives the same bytes: there is no date in them.

    Parameters
    ----------
    tell : called with a word before each step.
    """
    from takagi.reports.appendix.assembly import assembled
    from takagi.reports.appendix.blending import blending_context
    from takagi.reports.appendix.certificate import certificate_context
    from takagi.reports.appendix.conditions import conditions_context
    from takagi.reports.appendix.regional import region_context
    from takagi.reports.appendix.robustness import margins_context, trim_loops
    from takagi.reports.appendix.schedule import law_context
    from takagi.reports.appendix.tex import Tex, escape
    from takagi.reports.appendix.turbine import plant_context
    from takagi.reports.appendix.turbine_figures import drawn_figures

    say = tell or (lambda _: None)
    say("margins at the trims")
    loops, none = trim_loops(design)
    say("figures")
    figures = drawn_figures(design, loops)
    say("LaTeX")
    context: dict[str, object] = {
        **plant_context(design),
        **blending_context(design),
        **law_context(design),
        **conditions_context(design),
        **certificate_context(design),
        **margins_context(loops, none),
        "partial": region_context(design.partial_load, design.regional.partial, "b"),
        "full": region_context(design.full_load, design.regional.full, "c"),
        "subject": design.turbine.name,
        "title": f"{design.turbine.name}: multi-region controller design",
        "subtitle": Tex(
            rf"Derivation, law \texttt{{{escape(design.law.name)}}}, certificate and margins"
        ),
        "contents": True,
    }
    return assembled("turbine_body.tex.jinja", context, figures)

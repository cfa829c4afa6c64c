"""The files of a comparison of controllers: all runs, tables with intervals, a figure.

Intervals are of 95 %, by the bootstrap over the seeds; differences are paired by seed and wind.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from math import exp, gamma, isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from takagi.models.arrays import Floats, Places
from takagi.models.errors import ModelError
from takagi.reports.figures.style import COLOURS, figure_to_svg, house_style, new_figure
from takagi.reports.output import markdown_page, read_words, rows_csv
from takagi.reports.study.controllers import OURS, SETTLING, ControllersStudy, words_of
from takagi.reports.study.overlap import TURBULENCE
from takagi.reports.study.overlap_files import DECADES, DELS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CONFIDENCE = 0.95
RESAMPLES, SEED = 5000, 1
HOURS_A_YEAR = 8760.0


class Interval(NamedTuple):
    """A figure and its interval of 95 %."""

    value: float
    low: float
    high: float

    @property
    def is_clear(self) -> bool:
        """Whether the interval leaves out 0."""
        return self.low > 0 or self.high < 0

    @classmethod
    def of(cls, value: float, resampled: NDArray[np.float64]) -> Interval:
        """Return the percentile interval of the values of all resamples."""
        tail = 50 * (1 - CONFIDENCE)
        low, high = np.percentile(resampled, [tail, 100 - tail])
        return cls(float(value), float(low), float(high))


def resampled_seeds(seeds: int) -> Places:
    """Return ``RESAMPLES`` draws of as many seeds with replacement, (RESAMPLES, seeds).

    All quantities, winds and laws use the same draws: a seed has the same turbulence in all of
    them, so that differences between laws are paired.
    """
    return np.random.default_rng(SEED).integers(0, seeds, (RESAMPLES, seeds))


def mean_interval(values: Floats) -> Interval:
    """Return the mean over the seeds and its interval; ``values`` is (seeds,).

    Source: Efron and Tibshirani (1993), An Introduction to the Bootstrap, ch. 13 (percentiles).
    """
    draws = resampled_seeds(len(values))
    return Interval.of(float(np.mean(values)), values[draws].mean(axis=1))


@dataclass(frozen=True, slots=True)
class Weibull:
    """A distribution of the ten-minute mean wind.

    Attributes
    ----------
    mean : [m/s]: 10 in a place of IEC 61400-1 class I, 8.5 in class II.
    shape : [-]; 2 is Rayleigh's.

    Raises
    ------
    ModelError : a mean or shape that is not above 0.
    """

    mean: float = 8.5
    shape: float = 2.0

    def __post_init__(self) -> None:
        if not all(isfinite(v) and v > 0 for v in (self.mean, self.shape)):
            raise ModelError(
                f"a Weibull wind with mean {self.mean:g} m/s and shape {self.shape:g} was given; "
                "both must be above 0, such as 8.5:2"
            )

    @classmethod
    def read(cls, text: str) -> Weibull:
        """Return the distribution of MEAN:SHAPE."""
        try:
            mean, shape = (float(part) for part in text.split(":"))
        except ValueError as error:
            raise ModelError(
                f"--weibull {text} was given; MEAN:SHAPE is needed, such as 8.5:2 (m/s, and 2 for "
                "Rayleigh's distribution)"
            ) from error
        return cls(mean, shape)

    def below(self, wind: float) -> float:
        """Return the share of time with less wind [-]."""
        scale = self.mean / gamma(1 + 1 / self.shape)
        return 1 - exp(-((wind / scale) ** self.shape))

    def shares(self, means: Sequence[float], cut_in: float, cut_out: float) -> Floats:
        """Return the share of all time that each mean wind stands for, (winds,).

        A wind stands for all winds that are nearer to it than to another, as far beyond the first
        and the last as halfway to their neighbours, within cut-in and cut-out.
        """
        v = np.array(means)
        half = np.diff(v) / 2 if len(v) > 1 else np.ones(1)
        edges = np.concatenate([[v[0] - half[0]], v[:-1] + half[: len(v) - 1], [v[-1] + half[-1]]])
        below = np.array([self.below(e) for e in np.clip(edges, cut_in, cut_out)])
        return np.diff(below)


def lifetime_mean(values: Floats, shares: Floats) -> Interval:
    """Return the mean over all time of values (winds, seeds), 0 while the turbine stands."""
    draws = resampled_seeds(values.shape[1])
    over_winds = shares @ values
    return Interval.of(float(over_winds.mean()), over_winds[draws].mean(axis=1))


def lifetime_load(loads: Floats, shares: Floats, exponent: float) -> Interval:
    """Return the DEL at 1 Hz of all time, of the DELs (winds, seeds) by their damage."""
    draws = resampled_seeds(loads.shape[1])
    damage = shares @ loads**exponent
    return Interval.of(
        float(damage.mean() ** (1 / exponent)), damage[draws].mean(axis=1) ** (1 / exponent)
    )


FILES = ("controllers.md", "controllers.json", "study.csv")


class Quantity(NamedTuple):
    """A metric in tables: its words and unit, and whether more of it is better."""

    words: str
    unit: str
    more: bool = False

    @property
    def title(self) -> str:
        """Words and unit."""
        return f"{self.words} [{self.unit}]"


QUANTITIES: Mapping[str, Quantity] = {
    name: Quantity(**stated)
    for name, stated in read_words("study/words.toml")["controllers"].items()
}


def study_files(study: ControllersStudy, year: Weibull) -> dict[str, bytes | str]:
    """Return file name -> content: ``FILES`` and the figure; the same runs, the same bytes."""
    rows = [{"law": law, **run} for law in study.laws for run in study.runs[law]]
    files: dict[str, bytes | str] = {
        "study.csv": rows_csv(rows),
        "controllers.json": _json(study, year),
    }
    file, title = "figures/controllers.svg", f"{study.turbine.name}: controllers in all winds"
    if study.finished:
        figure = controllers_figure(study)
        files[file] = figure_to_svg(figure, name="study-controllers", description=title)
    files["controllers.md"] = _markdown(study, year, title=title, picture=file)
    return files


def difference(study: ControllersStudy, law: str, other: str, name: str, wind: int) -> Interval:
    """Return a law's metric less another's at the wind of a place, paired by seed."""
    return mean_interval(study.values(law, name)[wind] - study.values(other, name)[wind])


def _shares(study: ControllersStudy, year: Weibull) -> Any:
    return year.shares(study.means, study.turbine.cut_in, study.turbine.cut_out)


def year_totals(study: ControllersStudy, law: str, year: Weibull) -> dict[str, Interval]:
    """Return a law's energy a year [MWh], travel [deg/h] and DELs [MN m] of all time."""
    shares = _shares(study, year)
    energy = study.values(law, "mean_power") * HOURS_A_YEAR / 1e3
    totals = {
        "energy [MWh/year]": lifetime_mean(energy, shares),
        "pitch travel [deg/h]": lifetime_mean(study.values(law, "pitch_rate") * 3600, shares),
    }
    return totals | {
        QUANTITIES[name].title: lifetime_load(study.values(law, name), shares, exponent)
        for name, exponent in DELS.items()
    }


def ratios(
    study: ControllersStudy, law: str, other: str, year: Weibull
) -> dict[str, Interval | None]:
    """Return a law's totals of a year over another's, less 1 [%], paired by seed.

    None where the other has 0 with some seed.
    """
    shares = _shares(study, year)
    return {
        title: paired_ratio(study.values(law, name), study.values(other, name), shares, exponent)
        for title, name, exponent in (
            ("energy", "mean_power", 1.0),
            ("pitch travel", "pitch_rate", 1.0),
            *((QUANTITIES[name].words, name, exponent) for name, exponent in DELS.items()),
        )
    }


def paired_ratio(values: Any, others: Any, shares: Any, exponent: float) -> Interval | None:
    """Return 100 (L / L_other - 1) of loads (winds, seeds), the same seeds drawn for both."""
    damage, other = shares @ values**exponent, shares @ others**exponent
    if not (other > 0).all():
        return None
    draws = resampled_seeds(len(damage))

    def share(of: Any, against: Any) -> Any:
        return 100 * ((of / against) ** (1 / exponent) - 1)

    drawn = share(damage[draws].mean(axis=1), other[draws].mean(axis=1))
    return Interval.of(float(share(damage.mean(), other.mean())), drawn)


class Worse(NamedTuple):
    """Where ours is worse than another law: a metric, and the differences that are clear by wind.

    ``unclear`` are the winds at which the mean is worse and the interval contains 0.
    """

    other: str
    name: str
    clear: Mapping[float, Interval]
    unclear: tuple[float, ...]


def where_worse(study: ControllersStudy) -> Iterator[Worse]:
    """Yield every metric in which the effort-sharing law is worse than another law somewhere."""
    others = [law for law in study.finished if law != OURS] if OURS in study.finished else []
    for other, (name, quantity) in product(others, QUANTITIES.items()):
        sign = -1 if quantity.more else 1
        by_wind = {v: difference(study, OURS, other, name, k) for k, v in enumerate(study.means)}
        worse = {v: d for v, d in by_wind.items() if sign * d.value > 0}
        clear = {v: d for v, d in worse.items() if d.is_clear}
        if worse:
            yield Worse(other, name, clear, tuple(v for v in worse if v not in clear))


def _json(study: ControllersStudy, year: Weibull) -> str:
    compared = study.compared
    data: dict[str, Any] = {
        "model": study.turbine.name,
        "winds": list(study.means),
        "turbulence": TURBULENCE,
        "seeds": study.seeds,
        "duration": study.duration,
        "settling": SETTLING,
        "weibull": {**asdict(year), "shares": _shares(study, year).tolist()},
        "compared_with": compared,
        "units": {name: quantity.unit for name, quantity in QUANTITIES.items()},
        "failed": study.failed,
        "laws": {
            law: {
                "words": words_of(law),
                "metrics": {
                    name: [mean_interval(row)._asdict() for row in study.values(law, name)]
                    for name in QUANTITIES
                },
                "differences": {
                    name: [
                        difference(study, law, compared, name, k)._asdict()
                        for k in range(len(study.means))
                    ]
                    for name in (QUANTITIES if compared not in (None, law) else ())
                    if compared
                },
                "year": {k: v._asdict() for k, v in year_totals(study, law, year).items()},
            }
            for law in study.finished
        },
        "worse": [
            {
                "than": worse.other,
                "metric": worse.name,
                "clear": {f"{v:g}": d._asdict() for v, d in worse.clear.items()},
                "unclear": list(worse.unclear),
            }
            for worse in where_worse(study)
        ],
    }
    return json.dumps(data, indent=2, allow_nan=False) + "\n"


def _markdown(study: ControllersStudy, year: Weibull, **picture: str) -> str:
    compared = study.compared
    totals = {law: year_totals(study, law, year) for law in study.finished}
    against: dict[str, Mapping[str, Interval | None]] = {}
    if compared is not None:
        against = {x: ratios(study, x, compared, year) for x in totals if x != compared}
    worse = list(where_worse(study)) if OURS in totals and len(totals) > 1 else None
    return markdown_page(
        "study",
        "controllers",
        study=study,
        turbulence=TURBULENCE,
        settling=SETTLING,
        year=year,
        share=100 * _shares(study, year).sum(),
        totals=[
            {"law": words_of(law), **{title: total.value for title, total in row.items()}}
            for law, row in totals.items()
        ],
        compared=compared and words_of(compared),
        against=[
            {
                "law": words_of(law),
                **{f"{words} [%]": _with_interval(r) if r else None for words, r in row.items()},
            }
            for law, row in against.items()
        ],
        worse=worse and [_worse_row(found) for found in worse],
        metrics=[(q.title, _by_wind(study, name)) for name, q in QUANTITIES.items()],
        differences=[
            (q.title, _by_wind(study, name, compared)) for name, q in QUANTITIES.items() if compared
        ],
        **picture,
    )


def _worse_row(worse: Worse) -> dict[str, object]:
    return {
        "in": QUANTITIES[worse.name].title,
        "than": words_of(worse.other),
        "clear at [m/s]: by": ", ".join(f"{v:g}: {d.value:+.3g}" for v, d in worse.clear.items()),
        "within chance at [m/s]": ", ".join(f"{v:g}" for v in worse.unclear),
    }


def _by_wind(
    study: ControllersStudy, name: str, compared: str | None = None
) -> list[dict[str, object]]:
    def cell(law: str, k: int) -> object:
        if compared is None:
            return float(study.values(law, name)[k].mean())
        return _with_interval(difference(study, law, compared, name, k))

    winds = {f"{wind:g} m/s": k for k, wind in enumerate(study.means)}
    return [
        {"law": words_of(law), **{head: cell(law, k) for head, k in winds.items()}}
        for law in study.finished
        if law != compared
    ]


def _with_interval(figure: Interval) -> str:
    return f"{figure.value:+.3g} ({figure.low:+.3g} to {figure.high:+.3g})"


# What the figure shows; power as a difference, which would else hide behind its own curve.
PANELS = (
    *("mean_power", "tower_del", "shaft_del", "blade_del", "pitch_travel", "overspeed"),
    *("torque_change", "peak_power"),
)
# Colour, line and width of a law.
LOOKS: Mapping[str, tuple[str, Any, float]] = {
    OURS: (COLOURS[0], "-", 2.4),
    "schulte": (COLOURS[2], "-", 1.4),
    "switched": (COLOURS[2], ":", 1.4),
    "reference": (COLOURS[6], "-", 1.4),
    "rosco-shipped": (COLOURS[1], "-", 1.4),
    "rosco-shipped-unshaved": (COLOURS[1], "--", 1.2),
    "rosco-retuned": (COLOURS[3], "-", 1.4),
    "rosco-retuned-unshaved": (COLOURS[3], "--", 1.2),
}
OTHERS = (COLOURS[4], COLOURS[5])
# Below this the axis of the pitch travel is linear [deg].
FEW_DEGREES = 20.0


def controllers_figure(study: ControllersStudy) -> Figure:
    """Return the metrics over the mean wind, a line a law with its interval over the seeds."""
    with house_style():
        figure, panels = new_figure(len(PANELS) // 2, 2, height=9.4)
        for axes, name in zip(panels, PANELS, strict=True):
            _panel(axes, study, name)
        for axes in panels[-2:]:
            axes.set_xlabel("mean wind [m/s]")
        handles, labels = panels[1].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=2)
    return figure


def _panel(axes: Axes, study: ControllersStudy, name: str) -> None:
    compared = study.compared if name == "mean_power" else None
    files = [law for law in study.finished if law not in LOOKS]
    every = []
    for law in study.finished:
        other = OTHERS[files.index(law) % 2] if law in files else ""
        colour, line, width = LOOKS.get(law, (other, "-.", 1.4))
        if compared is None:
            figures = [mean_interval(row) for row in study.values(law, name)]
        else:
            figures = [difference(study, law, compared, name, k) for k in range(len(study.means))]
        every += [x.value for x in figures]
        axes.fill_between(
            study.means, [x.low for x in figures], [x.high for x in figures],
            color=colour, alpha=0.15, linewidth=0,
        )  # fmt: skip
        axes.plot(
            study.means, [x.value for x in figures], line, color=colour, linewidth=width,
            marker="o" if len(study.means) == 1 else None, label=words_of(law),
        )  # fmt: skip
    if name in DELS and max(every) > DECADES * min(every) > 0:
        axes.set_yscale("log")
    elif name == "pitch_travel" and max(every) > FEW_DEGREES:
        # In light wind it is 0, and a loop that swings has a hundred times that of the others.
        axes.set_yscale("symlog", linthresh=FEW_DEGREES)
    quantity = QUANTITIES[name]
    axes.set_ylabel(quantity.title if compared is None else f"power to reference [{quantity.unit}]")

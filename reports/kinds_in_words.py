"""Every kind of claim in words, for whoever reads: report, appendix, pages.

A new kind has its row here, and no words elsewhere: the heading of its theorem (``title``), its
line in a report (``name``, ``why``), its row of docs/claims.md and of docs/blends.md.  What the
claim states, with its numbers, is the ``sentence`` of its class in the checker.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

# What both checkers say of a kind for each kind of weights, in the order of docs/blends.md: shared,
# own, products, tables, secants.  A number is a note there.
Weights = tuple[str, str, str, str, str]
THEOREM: Weights = ("theorem",) * 5
NO_PLANT = "refused: no plant"
OTHER_MODEL: Weights = ("refused: another model",) * 5


@dataclass(frozen=True, slots=True, kw_only=True)
class KindInWords:
    """The words for one kind of claim.

    Attributes
    ----------
    title : heading of its theorem in the appendix, in LaTeX, with the source of the inequality.
    name : what it is about, in plain words.
    why : why the reader needs it, in one sentence.
    request : the class of ``takagi.certificates.requests`` that asks for it; empty if none does.
    proved : what is proved, in Markdown; empty for an embedding, which stands on a page of its own.
    assumed : what is assumed beside the model, in Markdown.
    weights : for which kinds of weights it is a theorem.
    weights_of : the same for variants of the claim, by what is different in them.
    """

    title: str
    name: str
    why: str
    request: str = ""
    proved: str = ""
    assumed: str = ""
    weights: Weights = THEOREM
    weights_of: Mapping[str, Weights] = field(default_factory=dict)


KINDS_IN_WORDS: Mapping[str, KindInWords] = {
    "sector-embedding": KindInWords(
        title=r"Exact embedding \cite{takagi-tanaka}",
        name="The model equals the plant",
        why="The other claims are then about the plant, not about an approximation.",
        weights=(NO_PLANT, NO_PLANT, "theorem", "theorem", "refused: its form"),
    ),
    "secant-embedding": KindInWords(
        title=r"Embedding in secants \cite{takagi-boyd}",
        name="The model contains the plant",
        why="The other claims are then about the plant, not about an approximation.",
        weights=(NO_PLANT, NO_PLANT, "refused: its form", "refused: its form", "theorem"),
    ),
    "decay": KindInWords(
        title=r"Common quadratic decay \cite{takagi-tanaka,takagi-boyd}",
        name="Motions come to rest",
        why="It says how fast the slowest motion is.",
        request="Decay",
        proved="V falls as e^(−2αt)",
    ),
    "transient": KindInWords(
        title=r"Overshoot and settling \cite{takagi-boyd}",
        name="Overshoot and settling time",
        why="It bounds a motion at every instant, not only at its end.",
        request="Transient",
        proved=(
            "|x(t)| ≤ κ e^(−αt) |x(0)| in scaled states; settled to a share of the start by a time"
        ),
    ),
    "region": KindInWords(
        title=r"Region of eigenvalues \cite{takagi-chilali}",
        name="Poles lie in the region",
        why="It bounds how fast and how well damped small motions are.",
        request="Poles",
        proved="poles of every blend, with weights at rest, lie in a region",
    ),
    "gain-rounding": KindInWords(
        title="Errors of the gains",
        name="Gains may be rounded",
        why="Gains may be stored with fewer digits, or differ a little in the controller.",
        request="GainRounding",
        proved="decay for all gains near the emitted ones",
    ),
    "no-common-decay": KindInWords(
        title="No common quadratic function",
        name="No common function decays this fast",
        why="Ask for less, or for a function that depends on the weights.",
        request="Decay",
        proved=(
            "DISPROVED: no common P decays at this rate (at the rate 0: has V' < 0 wherever x is "
            "not 0), by rules alone or by [blends](blends.md) that the file names"
        ),
        weights=("disproof", "open (9)", "disproof", "disproof", "open (9)"),
    ),
    "invariant-ellipsoid": KindInWords(
        title=r"Invariant set \cite{takagi-boyd}",
        name="Safe set",
        why="A motion that starts in the set never leaves it, nor the ranges.",
        request="InvariantEllipsoid",
        proved=(
            "{x'Px ≤ c} is never left and lies in the box of states; u = −Kx keeps the box's "
            "ranges of inputs; without disturbance V falls to 0; with |w_k| ≤ b_k, V comes back to"
            " c from outside"
        ),
        assumed="ranges of signals that only schedule, which the verdict names",
    ),
    "attraction-region": KindInWords(
        title=r"Region of attraction by squares \cite{takagi-tan-packard}",
        name="Larger safe set",
        why="Motions from this set come to rest too; it may be larger than any ellipsoid.",
        request="AttractionRegion",
        proved=(
            "every motion from {V ≤ c}, V a polynomial, stays in it and comes to rest; states and "
            "inputs keep their ranges; for [polynomial plants](wishes.md) in continuous time"
        ),
        assumed="disturbances at rest",
        weights=(NO_PLANT, NO_PLANT, "theorem", "open (14)", "refused: its form"),
    ),
    "input-limits": KindInWords(
        title=r"Inputs within limits \cite{takagi-boyd}",
        name="Inputs keep their limits",
        why="The actuators do not saturate, so that the other claims hold for them.",
        request="InputLimits",
        proved=(
            "on such a set |u_k| ≤ ū_k, u less its value at rest; also |u_k'|, or the change in "
            "one sample"
        ),
        assumed="for |u_k'| with gains that differ: bounds on |h_j'|",
        weights_of={
            "rates": ("theorem", "refused (1)", "theorem", "theorem", "refused (1)"),
        },
    ),
    "l2-gain": KindInWords(
        title=r"Energy gain \cite{takagi-boyd}",
        name="Effect of disturbances, as energy",
        why="It bounds what disturbances do on the whole.",
        request="L2Gain",
        proved=(
            "energy of y ≤ γ² times the energy of w, from rest; with `energy_bound` no state "
            "leaves the box"
        ),
        weights_of={
            "output by rule": ("theorem", "theorem", "theorem", "theorem", "refused (2)"),
        },
    ),
    "fuzzy-l2-gain": KindInWords(
        title=r"Energy gain by $P(h)$ \cite{takagi-oliveira}",
        name="Effect of disturbances, as energy",
        why="It bounds what disturbances do on the whole.",
        request="FuzzyL2Gain",
        proved="the same by V = x'P(h)x, where one P shows more than the loop does",
        assumed="bounds on how fast weights move, in continuous time",
        weights=("theorem", "refused (4)", "theorem", "theorem", "refused (5)"),
    ),
    "h2-norm": KindInWords(
        title=r"Response to white noise \cite{takagi-boyd}",
        name="Effect of white noise",
        why="It bounds the mean square of the output under noise.",
        request="H2Norm",
        proved="mean of E|y|² over time ≤ norm² for white noise",
        assumed=(
            "weights do not depend on future noise; the state stays in the box, which white noise "
            "leaves at some time; Itô's sense where noise enters by a matrix that varies"
        ),
        weights=("theorem (10)", "theorem (3, 10)", "theorem (10)", "theorem (10)", "theorem (10)"),
    ),
    "peak": KindInWords(
        title=r"Peak gain \cite{takagi-boyd}",
        name="Largest output",
        why="It bounds the output at every instant under a disturbance.",
        request="Peak",
        proved="|y| ≤ γ b at all times for |w| ≤ b, in an invariant set",
    ),
    "exit-probability": KindInWords(
        title=r"White noise \cite{takagi-kushner}",
        name="Probability of leaving the safe set",
        why="It says how safe the set is under noise.",
        request="ExitProbability",
        proved=(
            "P(x'Px reaches 1 within T) ≤ p [under white "
            "noise](plant-theorems.md#leaving-a-set-under-white-noise), for a set in the box"
        ),
        assumed="as for `h2-norm`; noise has no range in the box and is in no premise",
        weights=("theorem (10)", "theorem (3, 10)", "theorem (10)", "theorem (10)", "theorem (10)"),
    ),
    "sampled-loop": KindInWords(
        title="Sampled law",
        name="The law runs in samples",
        why="A computer holds each command until its next sample; the loop still comes to rest.",
        request="SampledLoop",
        proved=(
            "a law that runs every T seconds on a plant in continuous time and [holds its "
            "command](plant-theorems.md#a-law-that-runs-every-t-seconds): V falls from sample to "
            "sample, and between samples no state leaves its range"
        ),
        assumed="a sample exactly every T; no time for sensing and computing; no disturbance",
    ),
    "fuzzy-decay": KindInWords(
        title=r"Decay by $P(h)$ \cite{takagi-oliveira}",
        name="Motions come to rest",
        why="It says how fast the slowest motion is.",
        request="FuzzyDecay",
        proved="decay by a function that depends on the weights",
        assumed="bounds on how fast weights move, in continuous time",
        weights=("theorem", "refused (4)", "theorem", "theorem", "refused (5)"),
    ),
    "observer": KindInWords(
        title=r"Error of the observer \cite{takagi-tanaka}",
        name="The estimate converges",
        why="A law may then use the estimated states.",
        request="ObserverError",
        proved="e = x − x̂ decays, gains L_i",
        assumed=(
            "premises are measured (checked where the model says what they depend on), or the "
            "parts that are not measured enter by secants"
        ),
        weights=("theorem (6)", "theorem (6)", "theorem", "theorem", "refused (7)"),
    ),
    "observed-feedback": KindInWords(
        title=r"Law with its observer \cite{takagi-tanaka}",
        name="The law with its observer",
        why="The law has estimates in place of the states.",
        request="ObservedFeedback",
        proved="the loop with u = −K x̂ decays",
        assumed="the same",
        weights=("theorem (6)", "refused (4)", "theorem", "theorem", "refused (7)"),
    ),
    "observed-loop": KindInWords(
        title=r"Plant and observer together \cite{takagi-tanaka}",
        name="The loop with its observer",
        why="The law has the measured outputs alone, and estimates the other states.",
        request="ObservedLoop",
        proved=(
            "plant and observer of a law with [measured outputs](output-feedback.md) stay in a "
            "set, within the ranges of states and inputs, and V of both decays"
        ),
        assumed="exact outputs, no time for computing; no disturbance",
        weights=("theorem (6)", "refused (4)", "theorem", "theorem", "refused (7)"),
        weights_of={
            "by estimate": (
                "refused (11)",
                "refused (11)",
                "theorem",
                "refused (12)",
                "refused (7)",
            ),
        },
    ),
    "slope-embedding": KindInWords(
        title=r"Embedding of differences \cite{takagi-boyd}",
        name="The model contains all differences of motions",
        why="The error of the estimate then obeys the model too.",
        proved="differences between any two states of the box are blends of slopes",
        weights=(NO_PLANT, NO_PLANT, "theorem", "refused (12)", "theorem"),
    ),
    "tracking": KindInWords(
        title="Following a reference",
        name="Outputs follow their references",
        why="A constant reference is reached without error, within all ranges.",
        proved=(
            "at every constant [reference](tracking.md) in a range one rest without error in a "
            "stated set, and settling there from all of it; the jumps that keep all ranges; the "
            "error while it moves at a rate"
        ),
        assumed="signals without a rate are constant",
        weights=(NO_PLANT, NO_PLANT, "refused: its form", "refused: its form", "refused (13)"),
    ),
    "effort-blend": KindInWords(
        title="Two actuators, one effort",
        name="The two actuators share one effort",
        why="The law may command the effort alone: its share between them is covered.",
        proved=(
            "two actuators behind a [blend](blending.md) are the plant of the certificate: shares,"
            " limits, errors, and gains that depend only on what the law knows"
        ),
        assumed="errors are those stated, in the motion from rest",
        weights=(NO_PLANT, NO_PLANT, "theorem (8)", "theorem (8)", "refused (8)"),
    ),
    "bumpless": KindInWords(
        title="Hand-over without bumps",
        name="Hand-over without bumps",
        why="Neither command jumps, and each drive can be chosen for the rate.",
        proved=(
            "neither command jumps of [two actuators behind one effort]"
            "(blending.md#what-is-proved), and how fast each moves; of a turbine's torque and "
            "pitch (for Schulte's law: is asked to move)"
        ),
        assumed=(
            "state, signals and the effort's rate in the model's box; of a turbine: the claim it "
            "rests on"
        ),
        weights=(NO_PLANT, NO_PLANT, "theorem (8)", "theorem (8)", "refused (8)"),
    ),
    "feasible-point": KindInWords(
        title="A point that satisfies every constraint",
        name="The problem has a solution",
        why="A solver's solution may miss its constraints by a little; this one misses none.",
        proved="a [conic problem](verify.md) has a solution, and its optimum is at most the value",
        weights=OTHER_MODEL,
    ),
    "optimum-bound": KindInWords(
        title="A bound of the optimum",
        name="No solution is better",
        why="With a solution it encloses the optimum.",
        proved="every solution of a [conic problem](verify.md) has at least this value",
        assumed="where the sentence says so, variables within a box",
        weights=OTHER_MODEL,
    ),
    "no-solution": KindInWords(
        title="No solution",
        name="The constraints contradict one another",
        why="No solver finds a point, and it is no fault of the solver.",
        proved="no point satisfies the constraints of a [conic problem](verify.md)",
        weights=OTHER_MODEL,
    ),
    "unbounded": KindInWords(
        title="An objective without bound",
        name="The objective falls without end",
        why="A solver says that it failed; a limit is missing in the problem itself.",
        proved=(
            "the objective of a [conic problem](verify.md), or of its dual, has no bound: a "
            "point, and a ray along which it falls"
        ),
        weights=OTHER_MODEL,
    ),
    "coherent-loop": KindInWords(
        title="Invariance, bounds and decay",
        name="Bounded speed in a changing wind",
        why="No wind within the limits drives the rotor beyond this speed, in any of the plants.",
        proved=(
            "one set for all winds is never left; overspeed, torque and pitch bounded on it; decay"
            " at constant wind"
        ),
        assumed=(
            "wind limits in the law's schedule wind, which stays within the tables; pitch that "
            "starts at or above its lower limit; the rest stands in the sentence"
        ),
        weights=OTHER_MODEL,
    ),
    "paper-loop": KindInWords(
        title="The loop of Schulte's law",
        name="Settling, wind by wind",
        why="At each of these winds there is one operating point, and the loop returns to it.",
        proved="local stability of Schulte's law, wind cell by wind cell",
        assumed="constant wind that the law knows",
        weights=OTHER_MODEL,
    ),
    "wind-rate": KindInWords(
        title="Admissible winds",
        name="How fast a measured wind may change",
        why="Says in terms of the wind alone when the wind limits are kept.",
        proved=(
            "the law's filter keeps those limits while the wind's estimate moves no faster than "
            "r(v)"
        ),
        assumed="the estimate is off by at most η; the claim it rests on",
        weights=OTHER_MODEL,
    ),
    "set-points": KindInWords(
        title="Constant set-points of speed and power",
        name="Set-points at run time",
        why=(
            "A lower speed or power is asked for by two inputs, and the loop settles at every "
            "value."
        ),
        proved=(
            "at every constant wind and every constant pair of "
            "[set-points](laws.md#set-points-at-run-time) of a range the loop settles at the "
            "reference speed, from a set around it"
        ),
        assumed="constant wind that the law knows; nominal inertia, equilibrium wake",
        weights=OTHER_MODEL,
    ),
    "running-loop": KindInWords(
        title="The loop with its observer",
        name="Settling with the wind observer",
        why="The controller estimates the wind; with that estimate in the loop it still settles.",
        proved=(
            "the loop with the gain file's observer, filters and limits of rates settles from a "
            "stated set at a stated rate, wind cell by wind cell; the sentence names every wind "
            "that is left out"
        ),
        assumed=(
            "constant wind; a start with the schedule wind within the tables, pitch at or above "
            "its lower limit, torque and pitch where the law commands them; a wake with one state;"
            " rigid shaft, tower and blades; see [The loop that runs](running-loop.md)"
        ),
        weights=OTHER_MODEL,
    ),
}

"""Problems with known numbers: what is found here, and which tests hold it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """A problem of the literature, of a tool's manual or tests, or with a closed form.

    Attributes
    ----------
    name : short, unique.
    asks : what is asked.
    source : where data or number are from.
    published : the number there, or what is known exactly.
    found : what is found here, to the digits printed; "" for nothing.
    tests : names of the functions that hold it.
    note : what else must be known; why there is no test.
    """

    name: str
    asks: str
    source: str
    published: str
    found: str = ""
    tests: tuple[str, ...] = ()
    note: str = ""


# System -> least H-infinity norm and least H2 norm by all states: by Riccati, and as found here.
COMPLEIB = {
    "AC3": ("2.588071, 3.682621", "2.58807, 3.68262"),
    "AC15": ("14.855616, 12.298253", "14.8556, 12.2983"),
    "AC17": ("6.612428, 3.893781", "6.61243, 3.89378"),
    "DIS2": ("0.910425, 1.341505", "0.910425, 1.34151"),
    "HE1": ("0.060146, 0.031608", "0.060146, 0.031609"),
    "MFP": ("3.806769, 3.251426", "3.80677, 3.25143"),
    "NN2": ("1.498993, 1.482352", "1.49899, 1.48235"),
    "NN4": ("1.284393, 1.526794", "1.28439, 1.52680"),
    "REA1": ("0.502809, 1.266099", "0.50281, 1.26610"),
    "TG1": ("3.465234, 5.121369", "3.46524, 5.1215"),
}

SDPLIB = "Borchers (1999), SDPLIB 1.2"
QUOTED = "data not compared with the paper itself"
UNREAD = "not tested: the data file was not at hand"
BY_HAND = (
    "not tested: the data file is not part of this repository; run by hand with the whole "
    "collection, below: a candidate at the printed optimum"
)

PROBLEMS = (
    Problem(
        name="rolmip-massspring-g0",
        asks="energy gain of two masses and a spring with three parameters, one $P$",
        source="ROLMIP manual, table 2",
        published="2.8429",
        found="2.8429",
        tests=("test_masses_and_spring",),
    ),
    Problem(
        name="rolmip-massspring-g1",
        asks="the same, constant parameters, $P$ of degree 1",
        source="ROLMIP manual, table 2",
        published="1.0540",
        found="1.0540",
        tests=("test_masses_and_spring",),
    ),
    Problem(
        name="rolmip-massspring-g1-claim",
        asks="the same as a claim, proved in exact arithmetic by both checkers",
        source="ROLMIP manual, table 2",
        published="1.0540",
        found="1.0541",
        tests=("test_the_masses_of_rolmips_manual_are_proved_at_its_number",),
        note="`fuzzy-l2-gain` for constant numbers",
    ),
    Problem(
        name="rolmip-disc-7.1",
        asks="residuals of a printed pair of $P_i$, discrete time",
        source="ROLMIP manual, section 7.1",
        published="0.17957, 0.12168, 0.056108",
        found="0.17957, 0.12169, 0.05610",
        tests=("test_every_number_is_found_again", "test_the_rolmip_pair_has_none_and_says_so"),
        note="in rationals, for the printed decimals; there is no common $P$",
    ),
    Problem(
        name="yalmip-robust4",
        asks="least larger trace of $P_1$, $P_2$",
        source="YALMIP, test_robust_4.m",
        published="1.8203",
        found="1.8203",
        tests=("test_every_number_is_found_again",),
    ),
    Problem(
        name="yalmip-decay",
        asks="decay rate of one matrix",
        source="YALMIP, example decayrate",
        published="5/2 exactly",
        found="2.5000",
        tests=("test_every_number_is_found_again",),
    ),
    Problem(
        name="matlab-gevp",
        asks="common decay of three vertices",
        source="MathWorks, Robust Control Toolbox, gevp",
        published="$V' \\le -0.122\\, V$",
        found="0.12213",
        tests=("test_three_vertices_of_the_gevp_page",),
        note="twice the decay rate as it is counted here",
    ),
    Problem(
        name="matlab-feasp",
        asks="common $P$ of the same three",
        source="MathWorks, Robust Control Toolbox, feasp",
        published="feasible",
        found="candidate",
        tests=("test_every_status_is_found_again",),
    ),
    Problem(
        name="qi-tao-jiang-2.3",
        asks="common $P$ of two matrices, discrete time",
        source="Qi, Tao and Jiang, as in github S4JJ4D/MATLAB",
        published="feasible",
        found="candidate",
        tests=("test_every_status_is_found_again",),
    ),
    Problem(
        name="pc-G4-hinf",
        asks="H-infinity norm of a system of third order",
        source="python-control, sysnorm_test.py (by MATLAB)",
        published="4.276759162964244",
        found="4.27676",
        tests=("test_every_number_is_found_again",),
    ),
    Problem(
        name="pc-G4-h2",
        asks="H2 norm of the same",
        source="python-control, sysnorm_test.py (by MATLAB)",
        published="2.237461821810309",
        found="2.23746",
        tests=("test_every_number_is_found_again",),
    ),
    Problem(
        name="drake-cubic-roa",
        asks="region of attraction of $\\dot x = -x + x^3$",
        source="Drake, region_of_attraction_test.cc",
        published="$x^2 < 1$",
        found="0.9801",
        tests=("test_the_cubic_tends_to_its_analytic_region_from_below",),
        note="the level of $x^2$ in the box $\\lvert x \\rvert \\le 0.99$; it tends to 1",
    ),
    Problem(
        name="tw-p58",
        asks="gains for two rules, $a = 2.5$, $b = 25$",
        source="Tanaka and Wang (2001), page 58",
        published="feasible",
        found="candidate",
        tests=(
            "test_two_rules_have_gains_by_every_relaxation",
            "test_two_rules_have_gains_for_every_a_and_b",
        ),
        note="by every relaxation, also with one gain",
    ),
    Problem(
        name="tiw-fixedF-basic",
        asks="largest $b$ with a common $P$ for gains that place poles at $-2, -2$",
        source="Tanaka, Ikeda and Wang (1998); exactly $b + 1/b < 10/3$",
        published="$b < 3$",
        found="$2.99999 < b < 3$",
        tests=(
            "test_given_gains_have_a_common_function_exactly_below_three",
            "test_both_sides_of_a_threshold_exactly",
        ),
        note="both sides in rationals",
    ),
    Problem(
        name="pendulum-2rule",
        asks="gains of a pole on a cart by pole placement, and a common $P$",
        source="Wang, Tanaka and Griffin (1996)",
        published="a common $P$ exists",
        found="1.08720",
        tests=(
            "test_cart_pole_gains_are_those_published",
            "test_cart_pole_gains_have_a_common_function_and_this_decay_rate",
        ),
        note=f"the largest decay rate in 1/s of the loop with these gains; {QUOTED}",
    ),
    Problem(
        name="truck-trailer",
        asks="gains in discrete time; the printed ones must be refused",
        source="Tanaka and Sano (1994)",
        published="the printed $P$ certifies",
        found="it does not; $\\rho$ down to 0.99369",
        tests=(
            "test_truck_trailer_from_both_sides",
            "test_truck_trailer_gains_of_four_digits_are_refused",
            "test_printed_gains_of_the_truck_are_not_certified",
        ),
        note="$P$ misses by 0.0104 with gains of four digits; $\\rho$ is the contraction in a "
        f"sample that free gains reach; {QUOTED}",
    ),
    Problem(
        name="kimlee-3rule-a2",
        asks="largest $b$ with gains, by relaxation, $a = 2$",
        source="Kim and Lee (2000), Sala and Ariño (2007); limits recomputed",
        published="1.2593 Kim-Lee, 2.7252 Liu-Zhang, 1.2999 Pólya 2",
        found="each limit within 0.01",
        tests=("test_three_rules_close_to_each_limit",),
        note=f"{QUOTED}; at $b = 0$ none by one gain, all pairs, Tanaka-Wang, Tuan, Pólya 1",
    ),
    Problem(
        name="lpj12",
        asks="largest change with a common $P$",
        source="Shorten and Narendra (2002)",
        published="$4 + 4\\sqrt 2 = 9.656854$",
        found="$9.656853 < \\lambda < 9.656855$",
        tests=("test_both_sides_of_a_threshold_exactly",),
        note="both sides in rationals",
    ),
    Problem(
        name="dayawansa-martin",
        asks="largest $a$ with a common $P$",
        source="Dayawansa and Martin (1999)",
        published="$3 + \\sqrt 8 = 5.828427$",
        found="$5.828427 < a < 5.828428$",
        tests=(
            "test_both_sides_of_a_threshold_exactly",
            "test_planar_pair_has_a_common_p_exactly_between_its_limits",
        ),
        note=f"both sides in rationals; {QUOTED}",
    ),
    Problem(
        name="dstab-companion",
        asks="regions that hold the roots of $(s+2)(s+3)(s+5)$",
        source="exact",
        published="rate below 2, disc above 5, any sector",
        found="1.99 yes, 2.01 no; 5.01 yes, 4.99 no",
        tests=(
            "test_the_companion_matrix_from_both_sides",
            "test_a_disc_below_the_farthest_eigenvalue_is_not_accepted_at_a_tolerance",
        ),
        note="a float test at solver tolerance accepts the disc 4.983; here it is refused",
    ),
    Problem(
        name="ac15-sof",
        asks="least H-infinity norm by static output feedback, COMPleib AC15",
        source="github xi1ngang/Hinf-structured-output-Feedback",
        published="15.2919 HIFOO, 15.2 hinfstruct",
        found="below 15.2",
        tests=("test_static_output_feedback_of_ac15",),
        note="a direct search from their gain reached 15.1687; all states reach 14.8556",
    ),
    Problem(
        name="compleib-sof",
        asks="least H-infinity norm by static output feedback, 46 plants of COMPleib",
        source="Tran Dinh, Gumussoy, Michiels, Diehl (2012), IEEE TAC 57(6), the column of HIFOO",
        published="46 norms, [beside ours](output-feedback.md#comparison-with-hifoo)",
        found="each within 5 %, proved",
        tests=(
            "test_static_output_feedback_is_as_good_as_hifoos",
            "test_the_recalled_figures_are_those_of_the_run",
        ),
        note="the column was recalled; HIFOO itself, run on the same matrices, agrees",
    ),
    Problem(
        name="sdplib-control1",
        asks="least objective",
        source=SDPLIB,
        published="17.78463",
        found="17.785, at least 17.7846",
        tests=("test_control1_has_its_published_optimum",),
        note='clarabel alone says "Solved" at 18.056',
    ),
    *(
        Problem(
            name=f"sdplib-{name}",
            asks="least objective",
            source=SDPLIB,
            published=value,
            note=note,
        )
        for name, value, note in (
            ("control2", "8.300000", BY_HAND),
            ("control3", "13.63327", BY_HAND),
            ("hinf1", "2.0326", BY_HAND),
            ("hinf9", "236.25", BY_HAND),
            ("truss1", "-8.999996", UNREAD),
        )
    ),
    *(
        Problem(
            name=f"compleib-{name}-sf",
            asks="least H-infinity and H2 norm by all states",
            source="Leibfritz (2004), COMPleib 1.1",
            published=riccati,
            found=found,
            tests=("test_one_rule_has_the_optimum_of_compleib",),
            note="not printed there: the limits of the Riccati equations",
        )
        for name, (riccati, found) in COMPLEIB.items()
    ),
)

"""Reserved names of C and C++, comments, and the helper functions that a law may need."""

from __future__ import annotations

import re
from collections.abc import Collection

# Keywords of C11 and C++20, names of <math.h>, macros of common compilers and systems, and names
# that the generated files use themselves.
RESERVED = frozenset(
    """
    auto break case char const continue default do double else enum extern float for goto if inline
    int long register restrict return short signed sizeof static struct switch typedef union
    unsigned void volatile while _Bool _Complex _Imaginary alignas alignof and and_eq asm bitand
    bitor bool catch class compl concept consteval constexpr constinit const_cast co_await co_return
    co_yield decltype delete dynamic_cast explicit export false friend module import mutable
    namespace new noexcept not not_eq nullptr operator or or_eq private protected public
    reinterpret_cast requires static_assert static_cast template this thread_local throw true try
    typeid typename using virtual wchar_t xor xor_eq char8_t char16_t char32_t typeof main
    acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs
    fdim floor fma fmax fmin fmod frexp hypot ilogb ldexp lgamma llrint llround log log10 log1p log2
    logb lrint lround modf nan nearbyint nextafter nexttoward pow remainder remquo rint round
    scalbln scalbn sin sinh sqrt tan tanh tgamma trunc j0 j1 jn y0 y1 yn gamma signgam drem
    significand scalb finite isinf isnan isfinite isnormal signbit fpclassify isgreater isless
    isunordered islessgreater exp10 pow10 pow2 sincos float_t double_t matherr abs div labs
    NAN INFINITY HUGE_VAL HUGE EOF NULL DOMAIN SING OVERFLOW UNDERFLOW PLOSS TLOSS errno linux unix
    i386 near far small hyper interface min max IN OUT OPTIONAL TRUE FALSE ERROR CONST VOID I
    state inputs outputs kept next sent status limits good
    printf stdout stderr stdin
    """.split()  # noqa: SIM905 -- a table
)
_HEADERS = frozenset(
    """
    assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign
    stdarg stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar
    wchar wctype stdbit stdckdint
    """.split()  # noqa: SIM905 -- a table
)

# Helper -> (helpers that it calls, its text).  In a text @ means the prefix, REAL the type, and
# ZERO and ONE the numbers in that type.  A helper comes after those that it calls.
HELPERS: dict[str, tuple[tuple[str, ...], str]] = {
    "min": ((), """
static REAL @min(REAL a, REAL b)
{
    return b < a ? b : a;
}
"""),
    "max": ((), """
static REAL @max(REAL a, REAL b)
{
    return b > a ? b : a;
}
"""),
    "limit": ((), """
/* x held within low and high */
static REAL @limit(REAL x, REAL low, REAL high)
{
    const REAL above = low > x ? low : x;
    return high < above ? high : above;
}
"""),
    "power_2": ((), """
static REAL @power_2(REAL x)
{
    return x * x;
}
"""),
    "power_3": ((), """
static REAL @power_3(REAL x)
{
    return x * x * x;
}
"""),
    "power_4": ((), """
static REAL @power_4(REAL x)
{
    return (x * x) * (x * x);
}
"""),
    "interval": ((), """
/* the largest k with nodes[k] <= x, from 0 to count - 2 */
static int @interval(REAL x, const REAL *nodes, int count)
{
    int low = 0;
    int high = count - 1;
    while (high - low > 1) {
        const int middle = low + (high - low) / 2;
        if (nodes[middle] <= x) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}
"""),
    "slope": (("interval",), """
/* of the line between the two nodes around x */
static REAL @slope(REAL x, const REAL *nodes, const REAL *values, int count)
{
    const int k = @interval(x, nodes, count);
    return (values[k + 1] - values[k]) / (nodes[k + 1] - nodes[k]);
}
"""),
    "line": (("interval", "limit"), """
/* linear between the nodes; x is held within the first and the last */
static REAL @line(REAL x, const REAL *nodes, const REAL *values, int count)
{
    const int k = @interval(x, nodes, count);
    const REAL slope = (values[k + 1] - values[k]) / (nodes[k + 1] - nodes[k]);
    return values[k] + slope * (@limit(x, nodes[0], nodes[count - 1]) - nodes[k]);
}
"""),
    "hold": (("interval",), """
/* the value of the node below x */
static REAL @hold(REAL x, const REAL *nodes, const REAL *values, int count)
{
    return values[@interval(x, nodes, count)];
}
"""),
    "weigh": ((), """
/* the weight of each rule: for each premise w where the rule has 1, and 1 - w where it has 0 */
static void @weigh(REAL *weights, const unsigned char *rules, int count, const REAL *w,
                   int premises)
{
    int i;
    int k;
    for (i = 0; i < count; i++) {
        REAL product = ONE;
        for (k = 0; k < premises; k++) {
            product = product * (rules[i * premises + k] != 0 ? w[k] : ONE - w[k]);
        }
        weights[i] = product;
    }
}
"""),
    "mix": ((), """
/* the sum of the values times their weights */
static REAL @mix(const REAL *weights, const REAL *values, int count)
{
    REAL sum = ZERO;
    int i;
    for (i = 0; i < count; i++) {
        sum = sum + weights[i] * values[i];
    }
    return sum;
}
"""),
    "knot": ((), """
/* the largest j with knots[j] <= x, from 3 to count - 5 */
static int @knot(REAL x, const REAL *knots, int count)
{
    int low = 3;
    int high = count - 4;
    while (high - low > 1) {
        const int middle = low + (high - low) / 2;
        if (knots[middle] <= x) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}
"""),
    "de_boor": ((), """
/* cubic B-splines at x between knots[k] and knots[k + 1]; d holds their four coefficients */
static REAL @de_boor(REAL x, const REAL *knots, int k, REAL *d)
{
    int r;
    int j;
    for (r = 1; r <= 3; r++) {
        for (j = 3; j >= r; j--) {
            const REAL below = knots[j + k - 3];
            const REAL share = (x - below) / (knots[j + 1 + k - r] - below);
            d[j] = (ONE - share) * d[j - 1] + share * d[j];
        }
    }
    return d[3];
}
"""),
    "spline": (("knot", "de_boor", "limit"), """
/* a cubic spline; x is held within the knots */
static REAL @spline(REAL x, const REAL *knots, int count, const REAL *coefficients)
{
    const REAL held = @limit(x, knots[3], knots[count - 4]);
    const int k = @knot(held, knots, count);
    REAL d[4];
    int j;
    for (j = 0; j < 4; j++) {
        d[j] = coefficients[k - 3 + j];
    }
    return @de_boor(held, knots, k, d);
}
"""),
    "spline_2": (("knot", "de_boor", "limit", "spline"), """
/* a cubic spline of x and y; one row of coefficients for each spline of x */
static REAL @spline_2(REAL x, REAL y, const REAL *knots_x, int count_x, const REAL *knots_y,
                      int count_y, const REAL *coefficients)
{
    const REAL held = @limit(x, knots_x[3], knots_x[count_x - 4]);
    const int k = @knot(held, knots_x, count_x);
    REAL d[4];
    int j;
    for (j = 0; j < 4; j++) {
        d[j] = @spline(y, knots_y, count_y, coefficients + (k - 3 + j) * (count_y - 4));
    }
    return @de_boor(held, knots_x, k, d);
}
"""),
}  # fmt: skip


def helpers(used: Collection[str], prefix: str, real: str, suffix: str) -> str:
    """Return the text of the used helpers and of those that they call, in the order of C."""
    needed: set[str] = set()
    waiting = list(used)
    while waiting:
        one = waiting.pop()
        if one not in needed:
            needed.add(one)
            waiting += HELPERS[one][0]
    words = {"REAL": real, "ONE": f"1.0{suffix}", "ZERO": f"0.0{suffix}"}
    text = "".join(body for name, (_, body) in HELPERS.items() if name in needed)
    text = re.sub(r"\b(REAL|ONE|ZERO)\b", lambda found: words[found[1]], text)
    return text.replace("@", prefix)


def comment(text: str) -> str:
    """Return a text that is safe inside a comment or string of C: one line of ASCII."""
    plain = " ".join(text.split()).encode("ascii", "replace").decode("ascii")
    # First the backslashes: a slash in their place may end a comment.
    plain = plain.replace("\\", "/").replace('"', "'")
    return plain.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?")


def file_name_word(word: str) -> str:
    """Return a word W such that ``W.h`` has not the name of a standard header."""
    return f"law_{word}" if word in _HEADERS or word in RESERVED else word

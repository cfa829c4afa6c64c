"""Reserved names of C and C++, comments, and the helper functions that a law may need."""

from __future__ import annotations

import re
from collections.abc import Collection
from importlib.resources import files

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


def _read_helpers() -> dict[str, str]:
    text = (files("takagi.reports.code.c") / "helpers.c").read_text(encoding="utf-8")
    return {_CALLED.findall(helper)[0]: helper.strip() for helper in text.split("\n\n")}


_CALLED = re.compile(r"@(\w+)\(")
# Helper -> its text.  In a text @ means the prefix, REAL the type, and ZERO and ONE the numbers in
# that type.  A helper comes after those that it calls.
HELPERS = _read_helpers()


def helpers(used: Collection[str], prefix: str, real: str, suffix: str) -> str:
    """Return the text of the used helpers and of those that they call, in the order of C."""
    needed: set[str] = set()
    waiting = list(used)
    while waiting:
        helper = waiting.pop()
        if helper not in needed:
            needed.add(helper)
            waiting += _CALLED.findall(HELPERS[helper])
    words = {"REAL": real, "ONE": f"1.0{suffix}", "ZERO": f"0.0{suffix}"}
    text = "".join(f"\n{body}\n" for name, body in HELPERS.items() if name in needed)
    text = re.sub(r"\b(REAL|ONE|ZERO)\b", lambda match: words[match[1]], text)
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

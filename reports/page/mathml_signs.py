"""What the commands of LaTeX stand for in MathML."""

from __future__ import annotations

from types import MappingProxyType

_GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ϵ", "varepsilon": "ε",
    "zeta": "ζ", "eta": "η", "theta": "θ", "vartheta": "ϑ", "iota": "ι", "kappa": "κ",
    "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "omicron": "ο", "pi": "π", "rho": "ρ",
    "varrho": "ϱ", "sigma": "σ", "tau": "τ", "upsilon": "υ", "phi": "ϕ", "varphi": "φ",
    "chi": "χ", "psi": "ψ", "omega": "ω", "Gamma": "Γ", "Delta": "Δ", "Theta": "Θ",
    "Lambda": "Λ", "Xi": "Ξ", "Pi": "Π", "Sigma": "Σ", "Upsilon": "Υ", "Phi": "Φ", "Psi": "Ψ",
    "Omega": "Ω", "infty": "∞", "partial": "∂", "ell": "ℓ",
}  # fmt: skip
LETTERS = MappingProxyType({rf"\{name}": letter for name, letter in _GREEK.items()})

_NAMES = (
    "sin", "cos", "tan", "cot", "sec", "csc", "sinh", "cosh", "tanh", "coth", "arcsin", "arccos",
    "arctan", "log", "ln", "exp", "min", "max", "det", "lim",
)  # fmt: skip
FUNCTIONS = MappingProxyType({rf"\{name}": name for name in _NAMES})

_SIGNS = {
    "cdot": "⋅", "times": "×", "le": "≤", "leq": "≤", "ge": "≥", "geq": "≥", "ne": "≠",
    "approx": "≈", "in": "∈", "to": "→", "pm": "±", "sum": "∑", "prod": "∏", "ldots": "…",
    "dots": "…", "cdots": "⋯", "prec": "≺", "succ": "≻", "preceq": "⪯", "succeq": "⪰",
    "colon": ":", "mid": "|", "top": "⊤", "wedge": "∧", "vee": "∨", "circ": "∘",
    "{": "{", "}": "}", "|": "‖", "_": "_", "&": "&", "%": "%", "#": "#", "$": "$",
}  # fmt: skip
SIGNS = MappingProxyType({rf"\{name}": sign for name, sign in _SIGNS.items()})

# In em.
SPACES = MappingProxyType(
    {r"\,": 0.167, r"\:": 0.222, r"\;": 0.278, r"\ ": 0.3, r"\!": 0, r"\quad": 1, r"\qquad": 2}
)

ACCENTS = MappingProxyType(
    {r"\dot": "˙", r"\ddot": "¨", r"\bar": "¯", r"\overline": "¯", r"\hat": "^", r"\tilde": "~"}
)

# Letters of a group as one word.
WORDS = MappingProxyType(
    {
        r"\mathrm": '<mi mathvariant="normal">{}</mi>',
        r"\operatorname": '<mi mathvariant="normal">{}</mi><mo>&#x2061;</mo>',
        r"\mathit": '<mi class="name">{}</mi>',
        r"\text": "<mtext>{}</mtext>",
    }
)

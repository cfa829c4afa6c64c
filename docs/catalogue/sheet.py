"""The page as a LaTeX document: to look at its formulas without a browser."""

from __future__ import annotations

import re

HEAD = r"""\documentclass[10pt]{article}
\usepackage[a4paper,landscape,margin=12mm]{geometry}
\usepackage{amsmath,amssymb}
\setcounter{MaxMatrixCols}{20}
\setlength{\parindent}{0pt}
\begin{document}
"""


def sheet(page: str) -> str:
    """Return a document with the page's headings, bold lines and formulas.

    A formula that is wider than the paper makes TeX say "Overfull".
    """
    found = re.findall(
        r"^(#+ [^\n]*|\*\*[^\n]*\*\*)$|^```math\n(.*?)^```$", page, re.DOTALL | re.MULTILINE
    )
    parts = [_heading(line) if line else f"\\[\n{text}\\]\n" for line, text in found]
    return HEAD + "\n".join(parts) + "\\end{document}\n"


def _heading(line: str) -> str:
    words = line.strip("#* ").replace("`", "").replace("&", r"\&").replace("_", r"\_")
    words = re.sub(r"[<>]", lambda sign: f"${sign[0]}$", words.replace("°", r"$^\circ$"))
    size = r"\Large" if line.startswith("## ") else r"\large"
    return rf"\par\medskip {{{size}\bfseries {words}}}\par"

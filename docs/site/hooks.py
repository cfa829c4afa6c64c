"""What the site makes of the pages: formulas, files of the repository, and the public names."""

from __future__ import annotations

import ast
import posixpath
import re
from collections import defaultdict
from pathlib import Path
from typing import Any

from markdown import Extension, Markdown
from markdown.inlinepatterns import InlineProcessor
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from pymdownx.slugs import slugify
from pymdownx.superfences import SuperFencesException

from takagi.models import ModelError
from takagi.reports.page.mathml import mathml

ROOT = Path(__file__).resolve().parents[2]
# Files of the repository's root that are pages of the site.
ROOT_PAGES = {"CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md"}
PAGE_OF = {**ROOT_PAGES, "README.md": "index.md"}
# How much a page counts in a search: what explains a word comes before the many that use it.
COUNTS = {
    **dict.fromkeys(("api/", "changelog", "contributing", "architecture"), 0.2),
    **dict.fromkeys(("conditions", "benchmarks", "gallery-table"), 0.4),
    **dict.fromkeys(("tutorial", "glossary", "want", "cli"), 3.0),
}
LINK = re.compile(r"(?<=\]\()([^)#\s:]+)(?=[)#])")
# GitHub begins a list below a line of text; Python's Markdown wants an empty line between them.
LIST_BELOW_TEXT = re.compile(r"^((?![-*|>#\s]|\d+\. ).+\n)(?=[-*] |1\. )", re.MULTILINE)
FENCE = re.compile(r"(^```.*?^```$)", re.DOTALL | re.MULTILINE)
# A lone brace is taken for one that is left over from a command: these signs stand for it.
BRACES = {"{": "\u2774", "}": "\u2775"}
NAMES_OF = re.compile(r"^<!-- public names of (takagi[\w.]*) -->$", re.MULTILINE)


class InlineFormula(InlineProcessor):
    """A formula between $` and `$, as on GitHub."""

    def handleMatch(  # type: ignore[override]
        self, m: re.Match[str], data: str
    ) -> tuple[str, int, int]:
        return self.md.htmlStash.store(formula(m[1], block=False)), m.start(0), m.end(0)


class Formulas(Extension):
    """Formulas within the lines of GitHub's Markdown."""

    def extendMarkdown(self, md: Markdown) -> None:
        # Before inline code, because its marks belong to the formula's.
        md.inlinePatterns.register(InlineFormula(r"\$`([^`]+)`\$", md), "formula", 195)


def formula_block(source: str, *_: Any, **__: Any) -> str:
    """Return a fenced block of LaTeX as MathML; a keyboard can scroll it.

    Raises
    ------
    SuperFencesException : what is not converted; any other exception would be passed over.
    """
    try:
        set_in = formula(source.strip(), block=True)
    except ModelError as error:
        raise SuperFencesException(str(error)) from error
    aligned = " aligned" if "{aligned}" in source else ""
    return f'<div class="formula{aligned}" tabindex="0">{set_in}</div>'


def formula(latex: str, *, block: bool) -> str:
    """Return LaTeX of the pages as MathML: GitHub's has a little more than that of the reports."""
    latex = latex.replace(r"\begin{aligned}", r"\begin{array}{rl}")
    latex = latex.replace(r"\end{aligned}", r"\end{array}")
    latex = re.sub(r"\\([td]?)frac(\d)(\d)", r"\\\1frac{\2}{\3}", latex)
    for brace, sign in BRACES.items():
        latex = latex.replace(f"\\{brace}", sign)
    set_in = mathml(latex, block=block)
    for brace, sign in BRACES.items():
        set_in = re.sub(rf"<m[io]>{sign}</m[io]>", f"<mo>{brace}</mo>", set_in)
        set_in = set_in.replace(sign, f"\\{brace}")
    return set_in


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Set what mkdocs.yml could name only by strings that are executed."""
    config.markdown_extensions.append(Formulas())  # type: ignore[arg-type]
    config.mdx_configs["pymdownx.superfences"] = {
        "custom_fences": [{"name": "math", "class": "formula", "format": formula_block}]
    }
    # Headings have the anchors that they have on GitHub.
    config.mdx_configs["toc"]["slugify"] = slugify(case="lower")
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages of the repository's root, and every file that a page links to."""
    for name, page in ROOT_PAGES.items():
        files.append(File.generated(config, page, abs_src_path=str(ROOT / name)))
    linked = {
        target
        for file in files.documentation_pages()
        for link in LINK.findall(file.content_string)
        if (target := _outside(link, _home(file.src_uri)))
    }
    for target in sorted(linked):
        source = str(ROOT / target)
        files.append(File.generated(config, f"repository/{target}", abs_src_path=source))
    return files


def on_page_markdown(markdown: str, *, page: Page, **_: Any) -> str:
    """Return the page with links inside the site, lists as GitHub shows them, and public names."""
    uri = page.file.src_uri
    count = next((boost for start, boost in COUNTS.items() if uri.startswith(start)), 1.0)
    page.meta.setdefault("search", {"boost": count})

    def inside(found: re.Match[str]) -> str:
        path = posixpath.normpath(posixpath.join(posixpath.dirname(_home(uri)), found[1]))
        page_of = PAGE_OF.get(path)
        if page_of is None and path.startswith("docs/"):
            page_of = path.removeprefix("docs/")
        if page_of is None:
            page_of = f"repository/{path}"
        return posixpath.relpath(page_of, posixpath.dirname(uri) or ".")

    parts = FENCE.split(markdown)
    for k, part in enumerate(parts):
        if k % 2 == 0:
            parts[k] = LIST_BELOW_TEXT.sub(r"\1\n", LINK.sub(inside, part))
    return NAMES_OF.sub(lambda found: public_names(found[1]), "".join(parts))


def on_page_content(html: str, **_: Any) -> str:
    """Return the page's content with no table header that is empty."""
    return html.replace("<th></th>", "<td></td>")


def on_post_page(output: str, **_: Any) -> str:
    """Return the page with a name for the dialog that the theme leaves without one."""
    search = 'data-md-component="search" role="dialog"'
    return output.replace(search, f'{search} aria-label="Search"')


def _home(uri: str) -> str:
    """Return where a page of the site lies in the repository."""
    return next((name for name, page in ROOT_PAGES.items() if page == uri), f"docs/{uri}")


def _outside(link: str, home: str) -> str | None:
    """Return the file of the repository that a link of a page leads to; None inside the docs."""
    path = posixpath.normpath(posixpath.join(posixpath.dirname(home), link))
    known = path in PAGE_OF or path.startswith(("docs/", ".."))
    return path if not known and (ROOT / path).is_file() else None


def public_names(package: str) -> str:
    """Return the public names of a package, one room a section, as mkdocstrings' blocks."""
    rooms: dict[str, list[str]] = defaultdict(list)
    for module, name in _imports(_source(package)):
        room = module.removeprefix(f"{package}.").split(".")[0]
        named = f"{package}.{room}"
        rooms[named if _source(named).name == "__init__.py" else package].append(name)
    sections = []
    for room, names in sorted(rooms.items()):
        about = (ast.get_docstring(ast.parse(_source(room).read_text("utf-8"))) or "").split("\n")[
            0
        ]
        title = room.rpartition(".")[2].replace("_", " ").capitalize()
        heading = f"## {title}\n\n{about}" if room != package else "## Shared"
        if len(rooms) == 1:
            heading = ""
        blocks = [f"::: {package}.{name}" for name in sorted(names, key=str.lower)]
        sections.append("\n\n".join([heading, *blocks]))
    return "\n\n".join(sections)


def _source(module: str) -> Path:
    path = ROOT.joinpath(*module.split(".")[1:])
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def _imports(init: Path) -> list[tuple[str, str]]:
    """Return (module, name) of the imports ``from module import name as name``."""
    return [
        (node.module or "", alias.name)
        for node in ast.walk(ast.parse(init.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if alias.asname == alias.name
    ]

"""The makers of designs, one for turbines and one for plants; only this module chooses between.

A verb about a model calls a ``Maker`` and does not ask which kind of model it has.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from takagi.cli.options.given import Options, defaults_of, option_of
from takagi.cli.progress import Tell
from takagi.cli.runs.plant import PlantMaker
from takagi.cli.runs.turbine import TurbineMaker
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.design.design import CertifiedLaw, Design, NoDesign
    from takagi.models.loading import ModelFile


class Maker(Protocol):
    """Makes designs and certificates for one model.  Wrong options raise ``ModelError``.

    Attributes
    ----------
    words : the kind of model in words, for messages.
    options : those of a design.
    summary : name of the module that prints a design, with ``as_text`` and ``as_data``.
    simulation : name of the module that simulates, with ``OPTIONS`` and ``simulate``.
    """

    words: ClassVar[str]
    options: ClassVar[Options]
    summary: ClassVar[str]
    simulation: ClassVar[str]

    def __init__(self, source: Any, asked: Mapping[str, Any]) -> None:
        """Take the model's file, and those options of the command line that concern it."""

    @property
    def source(self) -> Any:
        """The model's file."""

    @property
    def asked(self) -> Mapping[str, Any]:
        """The options of the command line."""

    def design(self, tell: Tell) -> Design | NoDesign:
        """Return the finished design."""

    def certify(self, gains: Path, tell: Tell) -> CertifiedLaw | NoDesign:
        """Return the certificate of the law in a gain file; the gains are not changed.

        Raises
        ------
        CertificateError : the gain file is unreadable, or not for this model.
        """


MAKERS: Mapping[str, type[Maker]] = {"turbine": TurbineMaker, "plant": PlantMaker}
# The options of every verb that designs.
DESIGN_OPTIONS: Options = tuple(o for maker in MAKERS.values() for o in maker.options)
# Option -> what to use instead for the other kind of model, where this is not obvious.
_INSTEAD = {
    "law": "a plant's law is by rules: --relaxation and [design] of its file say how it is designed"
}


def maker_of(model: str, options: Mapping[str, Any]) -> Maker:
    """Return the maker for a built-in name or TOML file; the file is read here, once.

    Parameters
    ----------
    options : the parsed options of ``DESIGN_OPTIONS``.

    Raises
    ------
    ModelError : no such model, a file that is not TOML, or an option of the other kind of model.
    """
    from takagi.models.loading import read_model

    source = read_model(model)
    declared = {kind: maker.options for kind, maker in MAKERS.items()}
    return MAKERS[source.kind](source, own_options(source, options, declared))


def own_options(
    source: ModelFile, options: Mapping[str, Any], declared: Mapping[str, Options]
) -> dict[str, Any]:
    """Return those of the parsed options that concern the model.

    Parameters
    ----------
    declared : kind of model -> its options.

    Raises
    ------
    ModelError : an option of another kind of model was given.  Ignoring it would let the user
        believe that it had an effect.
    """
    own = defaults_of(declared[source.kind])
    for kind, others in declared.items():
        for name, default in defaults_of(others).items():
            if name not in own and options[name] != default and options[name] != []:
                instead = f" ({_INSTEAD[name]})" if name in _INSTEAD else ""
                raise ModelError(
                    f"option {option_of(name)} is about {MAKERS[kind].words}, but model "
                    f"{source.name} is {MAKERS[source.kind].words}{instead}; leave it out, or "
                    "choose another model"
                )
    return {name: options[name] for name in own}

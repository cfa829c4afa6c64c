"""The makers of designs, one for turbines and one for plants; only this module chooses between.

A verb about a model calls a ``Maker`` and does not ask which kind of model it has.  A maker is made
from the model's file and the options that concern it, ``source`` and ``asked``.  It has

    words             the kind of model, for messages
    options           those of a design
    summary           the module that prints a design, with ``as_text`` and ``as_data``
    simulation        the module that simulates, with ``OPTIONS`` and ``simulate``
    steps             those of a design and its report, for the line of progress
    design, certify   a design, or the certificate of a gain file's law; ``ModelError`` for options
                      that make no sense, ``CertificateError`` for a gain file of another model
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

from takagi.cli.options.given import Options, defaults_of, option_of
from takagi.cli.runs.plant import PlantMaker
from takagi.cli.runs.turbine import TurbineMaker
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.models.loading import ModelFile
    from takagi.models.turbine.loader import TurbineFile

Maker: TypeAlias = TurbineMaker | PlantMaker
MAKERS: Mapping[str, type[TurbineMaker] | type[PlantMaker]] = {
    "turbine": TurbineMaker,
    "plant": PlantMaker,
}
# The options of every verb that designs; one that both kinds have stands once.
DESIGN_OPTIONS: Options = tuple(
    {o.name: o for maker in MAKERS.values() for o in maker.options}.values()
)
# Option -> what to use instead for the other kind of model, where this is not obvious.
_INSTEAD = {
    "law": "a plant's law is by rules: --relaxation and [design] of its file say how it is designed"
}


def maker_of(model: str, options: Mapping[str, Any]) -> Maker:
    """Return the maker for a built-in name or TOML file; the file is read here, once.

    options : the parsed options of ``DESIGN_OPTIONS``.

    Raises ModelError: no such model, a file that is not TOML, or an option of the other kind of
        model.
    """
    from takagi.models.loading import read_model

    source: Any = read_model(model)
    declared = {kind: maker.options for kind, maker in MAKERS.items()}
    return MAKERS[source.kind](source, own_options(source, options, declared))


def turbine_file(model: str, does: str, instead: str) -> TurbineFile:
    """Return the file of a wind turbine.

    does, instead : what a verb does with laws of a turbine, and what there is for a plant.

    Raises ModelError: no such model, or another kind of it.
    """
    from takagi.models.loading import read_model

    source = read_model(model)
    if source.kind != "turbine":
        raise ModelError(
            f"takagi {does} of a wind turbine, but model {model} is {MAKERS[source.kind].words}; "
            f"{instead}"
        )
    return source


def own_options(
    source: ModelFile, options: Mapping[str, Any], declared: Mapping[str, Options]
) -> dict[str, Any]:
    """Return those of the parsed options that concern the model.

    declared : kind of model -> its options.

    Raises ModelError: an option of another kind of model was given.  Ignoring it would let the user
        believe that it had an effect.
    """
    allowed = defaults_of(declared[source.kind])
    for kind, others in declared.items():
        for name, default in defaults_of(others).items():
            if name not in allowed and options[name] != default and options[name] != []:
                instead = f" ({_INSTEAD[name]})" if name in _INSTEAD else ""
                raise ModelError(
                    f"option {option_of(name)} is about {MAKERS[kind].words}, but model "
                    f"{source.name} is {MAKERS[source.kind].words}{instead}; leave it out, or "
                    "choose another model"
                )
    return {name: options[name] for name in allowed}

r"""One sample of a plant's law by rules as a program: u = u* - sum_i h_i(z) K_i (x - x*).

With references the law has integral states, xi' = h(x) - r, which it keeps from sample to sample.
With integrators, x_c' = v, it keeps x_c, computes v as one more command, and reads those states
alone that it uses.

A single gain in ``K`` applies to all rules; only a law without premises has no weights. With a
blend the law commands the rate of the effort U. The program integrates this rate and shares U
between the two actuators.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Any

from takagi.certificates.checker.controller.decimals import exact
from takagi.certificates.checker.controller.language import (
    Item,
    keep,
    names_in,
    program,
    read,
    send,
    step,
)
from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.kernel.refusal import CertificateError


def plant_program(model: Any, law: Any, controller: Any, *, called: bool = False) -> Item:
    """Return the program.

    Parameters
    ----------
    model, law : the certificate's.
    controller : the gain file's own members: ``removable`` has the replacement of a premise near a
        point where its expression is 0/0.
    called : tables by their names, as plant files call them and earlier programs did.
    """
    return PlantWriting(model, law, controller, called=called).whole()


class _Names(dict[str, tuple[str, str]]):
    """Name -> (path, unit); a name has one path."""

    def __setitem__(self, name: str, value: tuple[str, str]) -> None:
        if self.get(name, value) != value:
            raise _two_meanings(name)
        super().__setitem__(name, value)


def _two_meanings(name: str) -> CertificateError:
    return CertificateError(
        f"the program would have one name, {name}, for two quantities: it joins names of the plant "
        "by '_'; give a state, input or output another name"
    )


class PlantWriting:
    """The parts of a plant's program as they are written."""

    def __init__(self, model: Any, law: Any, controller: Any, *, called: bool = False) -> None:
        self.called = called
        self.model, self.law, self.near = model, law, controller.get("removable", {})
        self.blending = law.get("blending")
        self.references = law.get("references", [])
        self.integrators = {i["rate"]: i["state"] for i in law.get("integrators", [])}
        self.taken = _plant_names(model, law)
        self.names = _Names()
        self.reads: list[Item] = []
        self.steps: list[Item] = []
        self.keeps: list[Item] = []
        self.sends: list[Item] = []

    def whole(self) -> Item:
        variables = variables_of(self.model, "states")
        effort = self.blending["effort"] if self.blending else ""
        kept = {effort, *(reference["integral"] for reference in self.references)}
        kept |= {*self.integrators.values()}
        used = [not self.integrators or self.uses(k, v) for k, v in enumerate(variables)]
        for k, variable in enumerate(variables):
            name, unit = variable["name"], variable["unit"]
            if not used[k]:
                continue
            if name not in kept:
                self.reads.append(read(name, unit, "measured"))
            self.names[self.own(f"{name}_rest")] = (f"law.trim.state.{k}", unit)
        deviations = [
            self.deviation(v) if use else "" for v, use in zip(variables, used, strict=True)
        ]
        if self.blending:
            self.share()
        weights = self.weights() if self.premises else []
        inputs = variables_of(self.model, "inputs")
        for k, variable in enumerate(inputs):
            self.command(k, variable, inputs, variables, deviations, weights)
        self.require_one(self.law.get("K", []), weights)
        if self.blending:
            self.actuators()
        for reference in self.references:
            self.integral(reference, inputs, variables)
        return self.finished()

    def finished(self) -> Item:
        """Return the program of these parts.

        Raises
        ------
        CertificateError : two of them have one name, as K_a_b_c of input a and state b_c has, and
            of input a_b and state c.
        """
        assigned = [*self.names, *(s["set"] for s in self.steps), *(k["name"] for k in self.keeps)]
        taken = {r["name"] for r in self.reads}
        for name in assigned:
            if name in taken:
                raise _two_meanings(name)
            taken.add(name)
        return program("law", self.names, reads=self.reads, keeps=self.keeps, steps=self.steps,
                       sends=self.sends)  # fmt: skip

    @property
    def premises(self) -> Any:
        """The premises that the gains depend on; one gain of a law with integrators has none."""
        return [] if self.integrators and len(self.law["K"]) == 1 else self.law.get("premises", [])

    def uses(self, column: int, state: Any) -> bool:
        """Return whether a state has a gain that is not zero, or is in a premise."""
        formulas = [str(p.get("expression", p["name"])) for p in self.premises]
        in_premises = not names_in(formulas).isdisjoint({state["name"], state.get("symbol")})
        gains = (row[column] for matrix in self.law["K"] for row in matrix)
        return in_premises or any(map(exact, gains))

    def require_one(self, stack: Any, weights: list[str]) -> None:
        """Refuse different matrices without weights: the program would use the first of them.

        Raises
        ------
        CertificateError : a law of several gains that does not say how it blends them.
        """
        rows = [[list(map(exact, row)) for row in matrix] for matrix in stack]
        if not weights and any(matrix != rows[0] for matrix in rows):
            raise CertificateError(
                "gains.premises: gains that differ, and no premises that say how they are blended: "
                "no program follows from them; name the premises, or give one gain"
            )

    def own(self, name: str) -> str:
        """Return a name of the program's own: one that the plant does not have."""
        while name in self.taken:
            name += "_"
        return name

    def deviation(self, variable: Any) -> str:
        """Write x - x* and return its name."""
        name = variable["name"]
        symbol = variable.get("symbol") or self.own(f"{name}_deviation")
        rest_name = self.own(f"{name}_rest")
        self.steps.append(step(symbol, variable["unit"], f"{name} - {rest_name}"))
        return str(symbol)

    def weights(self) -> list[str]:
        """Write premises and their weights; return the weights' names."""
        premises = self.premises
        formulas = [str(p.get("expression", p["name"])) for p in premises]
        self.signals(names_in(formulas))
        weight_names = []
        self.parameters(formulas)
        if len({p["name"] for p in premises}) != len(premises):
            raise CertificateError("gains.premises: different names are needed, also in a program")
        self.names[self.own("rules")] = ("law.rules", "-")
        for k, (premise, formula) in enumerate(zip(premises, formulas, strict=True)):
            name, unit = premise["name"], premise["unit"]
            if "expression" in premise:
                premise_formula = self.tables(formula)
                removable = [
                    {
                        **entry,
                        "of": self.tables(entry["of"]),
                        "formula": self.tables(entry["formula"]),
                    }
                    for entry in self.near.get(name, ())
                ]
                self.steps.append(step(name, unit, premise_formula, "premise", removable))
            else:
                self.reads.append(read(name, unit, "premise of the law, by its own definition"))
            low, high, weight = (self.own(f"{name}_{w}") for w in ("lower", "upper", "weight"))
            self.names[low] = (f"law.premises.{k}.lower", unit)
            self.names[high] = (f"law.premises.{k}.upper", unit)
            share = f"limit(({name} - {low})/({high} - {low}), 0, 1)"
            lower, upper = exact(premise["lower"]), exact(premise["upper"])
            flat = lower == upper
            if not flat and float(lower) == float(upper):
                raise CertificateError(
                    f"gains.premises: the bounds of {name} are one number in the floats of a "
                    "program, where the share would be 0/0; give bounds that are further apart, or "
                    "one bound twice"
                )
            self.steps.append(step(weight, "-", "0" if flat else share))
            weight_names.append(weight)
        return weight_names

    def parameters(self, formulas: list[str]) -> None:
        """Name the parameters in formulas."""
        for name in sorted(names_in(formulas) & set(self.model.get("parameters", {}))):
            self.names[name] = (f"parameters.{name}", "SI")

    def mixed(self, value: str, weights: list[str]) -> str:
        """Return the blend of a row of values, or the only value where there are no weights."""
        return f"mix({', '.join([self.own('rules'), value, *weights])})" if weights else value

    def signals(self, premise_names: set[str]) -> None:
        """Write the signals of premises other than states: disturbances and equilibrium inputs."""
        written_names = {self.blending["share"]} if self.blending else set()
        for key in ("disturbances", "inputs"):
            listed = self.model.get(key, []) if self.model.get("kind") == "plant" else []
            for k, variable in enumerate(listed):
                name, symbol = variable["name"], variable.get("symbol", variable["name"])
                if not premise_names & {name, symbol} or name in written_names:
                    continue
                if key == "inputs" or name in self.errors() or variable.get("unknown"):
                    self.steps.append(step(symbol, variable["unit"], "0", "not known: at rest"))
                    continue
                self.reads.append(read(name, variable["unit"], "measured"))
                if symbol != name:
                    rest_name = self.own(f"{name}_rest")
                    self.names[rest_name] = (f"signals.{k}.rest", variable["unit"])
                    self.steps.append(step(symbol, variable["unit"], f"{name} - {rest_name}"))

    def read_also(self, needed: set[str]) -> None:
        """Read those of these signals that the program does not read yet."""
        there = {program_input["name"] for program_input in self.reads}
        self.reads += [
            read(v["name"], v["unit"], "measured")
            for v in self.model["disturbances"]
            if v["name"] in needed - there
        ]

    def errors(self) -> set[str]:
        sides = (self.blending or {}).get("low"), (self.blending or {}).get("high")
        return {str(side["error"]) for side in sides if side and side["error"]}

    def tables(self, formula: str) -> str:
        """Name the tables that a formula calls; return it in the language of programs."""
        called = [
            name for name in self.model.get("tables", {}) if f"{name}(" in formula.replace(" ", "")
        ]
        for name in called:
            self.names[name] = (f"tables.{name}", "SI")
        return formula if self.called else with_splines(formula, called)

    def command(
        self, k: int, variable: Any, inputs: Any, states: Any, deviations: list[str],
        weights: list[str],
    ) -> None:  # fmt: skip
        name, unit = variable["name"], variable["unit"]
        rest_name, unlimited = self.own(f"{name}_rest"), self.own(f"{name}_wanted")
        self.names[rest_name] = (f"law.trim.input.{k}", unit)
        terms = []
        for j, (state, deviation) in enumerate(zip(states, deviations, strict=True)):
            if not deviation:
                continue
            gain = self.own(f"K_{name}_{state['name']}")
            rows = "*" if weights else "0"
            self.names[gain] = (f"law.K.{rows}.{k}.{j}", f"({unit})/({state['unit']})")
            terms.append(f"{self.mixed(gain, weights)}*{deviation}")
        self.steps.append(step(unlimited, unit, f"{rest_name} - ({' + '.join(terms)})", "the law"))
        if name in self.integrators:
            kept_state = _named(states, self.integrators[name], "gains.integrators: state")
            following = unlimited
            if self.law["sample_time"] is None:
                following = f"{kept_state['name']} + sample_time*{unlimited}"
            start = self.own(f"{kept_state['name']}_rest")
            words = "a state of the controller"
            self.keeps.append(keep(kept_state["name"], kept_state["unit"], start, following, words))
            return
        limited = unlimited
        if variable.get("range") is not None:
            limited = self.held(name, unlimited, f"inputs.{k}.range", unit)
        self.sends.append(send(name, unit, limited, "the command"))

    def held(self, name: str, unlimited: str, path: str, unit: str) -> str:
        """Return the command, limited to a range of the file."""
        ends = [self.own(f"{name}_{word}") for word in ("lowest", "highest")]
        for k, end in enumerate(ends):
            self.names[end] = (f"{path}.{k}", unit)
        return f"limit({unlimited}, {ends[0]}, {ends[1]})"

    # ------------------------------------------------------------------ references

    def integral(self, tracked: Any, inputs: Any, states: Any) -> None:
        """Write the integral of h - r; it stops where it would push a limited command further."""
        name, xi, h = tracked["reference"], tracked["integral"], tracked["follow"]
        signal = _named(self.model["disturbances"], name, "gains.references: reference")
        variable = _named(states, xi, "gains.references: integral")
        self.reads.append(read(name, signal["unit"], "the reference"))
        self.parameters([h])
        h = self.tables(h)
        error = self.own(f"{name}_error")
        self.steps.append(step(error, signal["unit"], f"{h} - {name}", "what is integrated"))
        limited = [v["name"] for v in inputs if v.get("range") is not None]
        if limited:
            # A command beyond its range moves on by -K (h - r); the product is negative there.
            terms = [
                f"({self.own(f'{u}_wanted')} - {u})*{self.own(f'K_{u}_{xi}')}*{error}"
                for u in limited
            ]
            free = f"choose({' + '.join(terms)}, 0, 1)"
        following = f"{xi} + sample_time*{error}{f'*{free}' if limited else ''}"
        rest_name = self.own(f"{xi}_rest")
        words = f"the integral of what follows {name}, less {name}"
        self.keeps.append(keep(xi, variable["unit"], rest_name, following, words))

    # ------------------------------------------------------------------ a blend

    def share(self) -> None:
        """Write the share F of the high actuator: the secant of psi from the equilibrium."""
        b, variables = self.blending, self.model["disturbances"]
        share = _named(variables, b["share"], "gains.blending.share")
        U, eps = b["effort"], self.own("overlap")
        rest_name, off = self.own(f"{U}_rest"), self.own(f"{U}_off")
        self.names[eps] = ("law.blending.overlap", b["unit"])
        here, there = (f"limit({s}, -{eps}, {eps})" for s in (U, rest_name))
        curved = f"({here} - {there})*({here} + {there} + 2*{eps})/(4*{eps})"
        straight = f"max({U}, {eps}) - max({rest_name}, {eps})"
        at_rest = f"({there} + {eps})/(2*{eps})"
        self.steps += [
            step(off, b["unit"], f"{U} - {rest_name}"),
            step(share["name"], "-", f"({curved} + {straight})/{off}",
                 "(psi(U) - psi(U*))/(U - U*)",
                 [{"of": off, "within": Number("0"), "formula": at_rest}]),
        ]  # fmt: skip
        if share.get("symbol", share["name"]) != share["name"]:
            self.steps.append(step(share["symbol"], "-", f"{share['name']} - {at_rest}"))

    def actuators(self) -> None:
        """Write the integration of the effort, and the commands of the two actuators."""
        b = self.blending
        U, eps = b["effort"], self.own("overlap")
        following = f"{U} + sample_time*{b['rate']}"
        self.keeps.append(
            keep(U, b["unit"], self.own(f"{U}_rest"), following, "the effort that is shared")
        )
        for side, sign in (("low", "-"), ("high", "")):
            actuator, s = b[side], f"{sign}{U}"
            name, effectiveness = actuator["input"], actuator["effectiveness"]
            self.parameters([effectiveness])
            self.read_also(names_in([effectiveness]))
            effectiveness = self.tables(effectiveness)
            idle = self.own(f"{name}_idle")
            self.names[idle] = (f"law.blending.{side}.idle", actuator["unit"])
            psi = f"max({s}, (limit({s}, -{eps}, {eps}) + {eps})^2/(4*{eps}))"
            toward = "-" if (side == "low") == (float(actuator["direction"]) > 0) else "+"
            commanded = f"{idle} {toward} {psi}/({effectiveness})"
            if actuator["range"] is not None:
                commanded = self.held(
                    name, commanded, f"law.blending.{side}.range", actuator["unit"]
                )
            words = f"psi({s}) over its effectiveness"
            self.sends.append(send(name, actuator["unit"], commanded, words))


def _split(label: str) -> tuple[str, str]:
    name, _, unit = str(label).partition(" [")
    return name, unit.removesuffix("]")


def variables_of(model: Any, key: str) -> list[Any]:
    """Return the plant's variables, or the variables of the model if there is no plant."""
    if model.get("kind") == "plant":
        return list(model[key])
    labels = model["state_names" if key == "states" else "input_names"]
    return [dict(zip(("name", "unit"), _split(label), strict=True)) for label in labels]


def _plant_names(model: Any, law: Any) -> set[str]:
    """Return the names that the plant, its premises and its tables have."""
    names = {"sample_time", *(p["name"] for p in law.get("premises", []))}
    if model.get("kind") != "plant":
        return names
    for key in ("states", "inputs", "disturbances"):
        for variable in model[key]:
            names |= {variable["name"], variable.get("symbol", variable["name"])}
    return names | set(model.get("parameters", {})) | set(model.get("tables", {}))


def with_splines(formula: str, tables: Collection[str]) -> str:
    """Return the formula with ``name(x, ...)`` as ``spline(x, ..., name)`` for each table."""
    for name in tables:
        call = re.search(rf"(?<![\w.]){re.escape(name)}\s*\(", formula, re.ASCII)
        while call:
            start, end = call.end(), _closing(formula, call.end())
            inner = formula[start:end]
            # The name now follows a comma, so it is not found again.
            formula = f"{formula[: call.start()]}spline({inner}, {name}{formula[end:]}"
            call = re.search(rf"(?<![\w.]){re.escape(name)}\s*\(", formula, re.ASCII)
    return formula


def _closing(formula: str, start: int) -> int:
    """Return the index of the bracket that closes the one before ``start``."""
    depth = 1
    for position in range(start, len(formula)):
        depth += {"(": 1, ")": -1}.get(formula[position], 0)
        if depth == 0:
            return position
    raise ValueError(f"{formula[:60]!a} has a bracket that is not closed")


def _named(variables: Any, name: Any, where: str) -> Any:
    """Return the variable of a name; refuses a name that none has."""
    for variable in variables:
        if variable["name"] == name:
            return variable
    raise CertificateError(f"{where}: the model has no variable {name!a:.60}")

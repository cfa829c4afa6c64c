r"""One sample of a law with measured outputs as a program: an observer, and gains on its estimate.

    u = u* - sum_i h_i K_i s,
    s' = A(z) s + B(z) (u - u*) + sum_i h_i L_i (y - y* - C(z) s - D(z) (u - u*)).

A(z), B(z), C(z), D(z) are the entries of the embedding.  The program keeps x* + s from sample to
sample.  In continuous time it takes one Euler step with the sample time; in discrete time the right
side is the next s.  A directly measured state starts at its first measurement, every other state at
rest.  u is the command after its limits.

With references the matrices are numbers of the law (``gains.observer``), the integrals are states
of the law beside the estimate, and what follows is computed from what is measured.

If the weights are those at the estimate, the premises are computed from the estimate: then the
stored values have the names of the states, and are held in the ranges of the model, beyond which a
premise may have no value.  In the proved set they never reach these limits.  Otherwise the premises
are computed from the measured states, which then have these names.
"""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.controller.decimals import exact
from takagi.certificates.checker.controller.language import (
    WORD,
    Item,
    keep,
    names_in,
    read,
    step,
)
from takagi.certificates.checker.controller.plant_program import PlantWriting, variables_of
from takagi.certificates.checker.kernel.refusal import CertificateError


def observer_program(model: Any, law: Any, controller: Any) -> Item:
    """Return the program; the parameters are those of ``plant_program``."""
    writing = _ObserverWriting(model, law, controller)
    # Files of before neither state the longest sample time nor hold estimates.
    writing.holds = "sampling" in controller
    return writing.whole()


def measured_reads(model: Any, law: Any, used_names: set[str]) -> list[tuple[str, Any]]:
    """Return for each measured output the name under which it is read, and the output.

    Parameters
    ----------
    used_names : names that the program already uses.
    """
    outputs = {y["name"]: y for y in model["outputs"]}
    states = {v["name"] for v in model["states"]}
    at_estimate = law["observer"]["weights"] == "estimated"
    reads = []
    for name in law["observer"]["measured"]:
        output = outputs[name]
        if str(output["expression"]) in states and not at_estimate:
            reads.append((str(output["expression"]), output))
            continue
        word = f"{name}_measured"
        while word in used_names:
            word += "_"
        reads.append((word, output))
    return reads


def _known(reference: Any, outputs: Any, direct: Any, names: set[str]) -> str:
    """Return what follows a reference in what the law measures.

    Raises
    ------
    CertificateError : it is measured neither itself nor by the states in it.
    """
    h = str(reference["follow"])
    if names_in([h]) & names <= direct.keys():
        return h
    for word, y in outputs:
        if str(y["expression"]) == h:
            return str(word)
    raise CertificateError(f"gains.observer: what follows {reference['reference']} is not measured")


class _ObserverWriting(PlantWriting):
    holds = True
    own_states: list[Any]

    def whole(self) -> Item:
        states, inputs = (variables_of(self.model, key) for key in ("states", "inputs"))
        observer, names = self.law["observer"], {v["name"] for v in states}
        at_estimate = observer["weights"] == "estimated"
        self.holds = at_estimate and self.holds
        outputs = measured_reads(self.model, self.law, self.taken)
        self.taken |= {word for word, _ in outputs}
        for k, v in enumerate(states):
            self.names[self.own(f"{v['name']}_rest")] = (f"law.trim.state.{k}", v["unit"])
        for word, y in outputs:
            self.reads.append(read(word, y["unit"], "measured"))
        direct = {y["expression"]: word for word, y in outputs if y["expression"] in names}
        integrals = {reference["integral"] for reference in self.references}
        estimates, deviations = [], []
        for v in states:
            if v["name"] in integrals:
                estimates.append(v["name"])
                deviations.append(self.deviation(v))
                continue
            if at_estimate:
                estimates.append(v["name"])
                deviations.append(self.deviation(v))
                continue
            if v["name"] in direct and v.get("symbol") and not self.references:
                self.deviation(v)
            estimates.append(self.own(f"{v['name']}_estimate"))
            deviations.append(self.own(f"{v['name']}_estimated"))
            rest_name = self.own(f"{v['name']}_rest")
            self.steps.append(step(deviations[-1], v["unit"], f"{estimates[-1]} - {rest_name}"))
        weights = self.weights() if self.law.get("premises") else []
        self.require_one(self.law.get("K", []), weights)
        if self.references and observer["weights"] != "constant":
            raise CertificateError("gains.observer: with references its matrices are constant")
        self.require_one([] if self.references else observer.get("L", []), weights)
        pushes = []
        for k, u in enumerate(inputs):
            self.command(k, u, inputs, states, deviations, weights)
            pushes.append(self.sent(u))
        self.own_states = [v for v in states if v["name"] not in integrals]
        gaps = [self.gap(p, *y, deviations, pushes) for p, y in enumerate(outputs)]
        for k, v in enumerate(states):
            if v["name"] in integrals:
                continue
            rate = self.rate(k, v, outputs, deviations, pushes, gaps, weights)
            rest_name = self.own(f"{v['name']}_rest")
            discrete = self.model["sample_time"] is not None
            following = (
                f"{rest_name} + {rate}" if discrete else f"{estimates[k]} + sample_time*({rate})"
            )
            start = direct.get(v["name"], rest_name)
            if self.holds and v.get("range") is not None:
                path = f"states.{k}.range"
                start, following = (
                    self.held(v["name"], reference, path, v["unit"])
                    for reference in (start, following)
                )
            self.keeps.append(
                keep(estimates[k], v["unit"], start, following, f"estimate of {v['name']}")
            )
        for reference in self.references:
            self.integral(
                {**reference, "follow": _known(reference, outputs, direct, names)}, inputs, states
            )
        return self.finished()

    def sent(self, u: Any) -> str:
        """Write the limited command and its deviation; return the name of the deviation."""
        limited, push = self.own(f"{u['name']}_held"), self.own(f"{u['name']}_push")
        self.steps.append(step(limited, u["unit"], self.sends[-1]["formula"], "the command"))
        self.sends[-1]["formula"] = limited
        rest_name = self.own(f"{u['name']}_rest")
        self.steps.append(step(push, u["unit"], f"{limited} - {rest_name}"))
        return push

    def gap(self, p: int, word: str, y: Any, deviations: list[str], pushes: list[str]) -> str:
        """Write y, the p-th output, less the output of the estimate, and return its name."""
        if self.references:
            expected = self.numbers("C", p, y, self.estimated(deviations))
        else:
            row = [output["name"] for output in self.model["outputs"]].index(y["name"])
            expected = [
                *self.products("C", row, deviations),
                *self.products("D", row, pushes),
            ]
        gap_name = self.own(f"{y['name']}_gap")
        subtracted = "".join(f" - {term}" for term in expected)
        self.steps.append(step(gap_name, y["unit"], f"{word} - ({self.at_rest(y)}){subtracted}"))
        return gap_name

    def at_rest(self, y: Any) -> str:
        """Return the value of an output at rest: its expression at the equilibrium values."""
        formula = str(y["expression"])
        self.tables(formula)
        variables = {v["name"] for key in ("states", "inputs") for v in self.model[key]}
        self.parameters([formula])

        def rest(word: Any) -> str:
            return self.own(f"{word[0]}_rest") if word[0] in variables else str(word[0])

        return WORD.sub(rest, formula)

    def rate(
        self, k: int, state: Any, outputs: Any, deviations: list[str], pushes: list[str],
        gaps: list[str], weights: list[str],
    ) -> str:  # fmt: skip
        path = ""
        if self.references:
            k = self.own_states.index(state)
            inputs = zip(variables_of(self.model, "inputs"), pushes, strict=True)
            terms = [
                *self.numbers("A", k, state, self.estimated(deviations)),
                *self.numbers("B", k, state, list(inputs)),
            ]
            path = f"law.observer.L.{k}"
        else:
            terms = [*self.products("A", k, deviations), *self.products("B", k, pushes)]
        for p, ((_, y), gap) in enumerate(zip(outputs, gaps, strict=True)):
            gain = self.own(f"L_{state['name']}_{y['name']}")
            rows = "*" if weights else "0"
            unit = f"({state['unit']})/({y['unit']})"
            if self.model["sample_time"] is None:
                unit += "/s"
            self.names[gain] = (f"{path or f'law.observer.L.{rows}.{k}'}.{p}", unit)
            terms.append(f"{self.mixed(gain, weights)}*{gap}")
        return f"({' + '.join(terms)})"

    def estimated(self, deviations: list[str]) -> list[tuple[Any, str]]:
        """Return the states that the observer estimates, each with the name of its deviation."""
        pairs = zip(variables_of(self.model, "states"), deviations, strict=True)
        return [(v, name) for v, name in pairs if v in self.own_states]

    def numbers(self, letter: str, k: int, to: Any, columns: list[tuple[Any, str]]) -> list[str]:
        """Return the products of a row of the observer's own matrix that are not 0."""
        terms = []
        for j, (v, name) in enumerate(columns):
            if not exact(self.law["observer"][letter][k][j]):
                continue
            entry = self.own(f"{letter}_{to['name']}_{v['name']}")
            unit = f"({to['unit']})/({v['unit']})" + ("" if letter == "C" else "/s")
            self.names[entry] = (f"law.observer.{letter}.{k}.{j}", unit)
            terms.append(f"{entry}*{name}")
        return terms

    def products(self, letter: str, row: int, columns: list[str]) -> list[str]:
        """Return the products of a row of the embedding that are not 0."""
        entries = self.model["embedding"].get(letter)
        if entries is None:
            return []
        listed = self.model["embedding"].get("numbers", [])
        formulas = {n["name"]: f"({n['expression']})" for n in listed}
        terms = []
        for entry, column in zip(entries[row], columns, strict=True):
            text = WORD.sub(lambda word: formulas.get(word[0], word[0]), str(entry))
            if text == "0":
                continue
            terms.append(column if text == "1" else f"({text})*{column}")
        return terms

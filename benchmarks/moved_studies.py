"""Error of a study's equation for e_n over the processor time of its runs, on moved meshes and on new ones.

Run from the root: ``python benchmarks/moved_studies.py [three|five] [--picture FILE]``; three factors are the
paper's. Held-out designs, whose time is not counted, are solved to 0.3 %. On one thread; ten minutes.
"""

import argparse
import os
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.diagrams import figure, legend_inside, order_line_style
from crankfem.analyses.study.response_fits import fit_study
from fem.material import Material
from fem.moved_mesh import ReferenceMesh, make_reference
from fem.responses import ThrowResponses, evaluate_throw
from geometry.mesh import keep_solids
from geometry.mesher import mesh_here
from geometry.throw import CrankThrow
from paper_study import THROW
from regression.plans.designs import DesignChoice
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan
from regression.records import HELD_OUT, MESHED, MOVED, RUN, SLOPES, Outcome
from regression.runs.study_table import study_table
from regression.runs.workers import ONE_THREAD, evaluate_design
from study_slopes import BOXES

RESPONSE = "axial_compliance_pinned"
TRUE_ACCURACY = 0.003
# Runs without slopes and with them.
RUNS = {"three": ((20, 33), (5, 8)), "five": ((60,), (14,))}
WAYS = (("new", 0.04), ("new", 0.01), ("moved", 0.04), ("moved", 0.01))


class Study:
    """Runs of a plan in this process, timed."""

    def __init__(self, plan: StudyPlan, truth: dict[str, ThrowResponses]) -> None:
        self.seconds = 0.0
        self._references: dict[str, ReferenceMesh] = {}
        designs = plan.planned.designs
        self.kinds: list[str] = []
        outcomes = {}
        for design in designs:
            if design.role == HELD_OUT and not design.ordinary:
                known = truth[_place(design.values)]
                outcomes[design.key] = _outcome(design.key, design.inputs, known)
                continue
            outcomes[design.key] = self._solved(design.key, design.inputs)
            if design.ordinary:
                outcomes[design.ordinary[0]] = self._solved(*design.ordinary)
        # The scatter of error bars takes part in the choice of a form: held-out designs have those of runs.
        table = study_table(plan, designs, outcomes)
        bar = {RESPONSE: float(np.median(table.errors[RESPONSE][~table.held_out]))}
        for design in designs:
            if design.role == HELD_OUT and not design.ordinary:
                outcomes[design.key] = replace(outcomes[design.key], errors=bar)
        table = study_table(plan, designs, outcomes)
        chosen = fit_study(table)["axial_compliance"].chosen
        assert chosen.largest_heldout_error is not None
        self.errors = chosen.largest_heldout_error, chosen.mean_heldout_error

    def _solved(self, key: str, inputs: Any) -> Outcome:
        begin = time.process_time()
        reference = None
        if MOVED in inputs:
            name = str(inputs[MOVED])
            if name not in self._references:
                throw = CrankThrow(**inputs[MOVED]["throw"])
                self._references[name] = make_reference(throw, inputs[MOVED]["paths"], mesh_here)
            reference = self._references[name]
        found = evaluate_throw(
            CrankThrow(**inputs["throw"]),
            Material(**inputs["material"]),
            inputs["accuracy"],
            mesher=mesh_here,
            slopes=inputs.get(SLOPES, ()),
            reference=reference,
        )
        self.seconds += time.process_time() - begin
        tier = found.moved.tier if found.moved else MESHED
        self.kinds.append(tier)
        mesh = {"tier": tier, "discrete": found.discrete} if MOVED in inputs else {}
        return _outcome(key, inputs, found, mesh)


def _place(values: tuple[float, ...]) -> str:
    return ",".join(f"{value:.9g}" for value in values)


def _outcome(key: str, inputs: Any, found: ThrowResponses, mesh: Any = None) -> Outcome:
    """Outcome of what was evaluated, of one response."""
    return Outcome(
        key,
        inputs,
        {RESPONSE: found.values[RESPONSE]},
        None,
        0.0,
        errors={RESPONSE: found.errors[RESPONSE]},
        slopes={name: over for name, over in found.slopes.items() if name == RESPONSE},
        slope_errors=found.slope_errors,
        mesh=mesh or {},
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("box", nargs="?", default="three", choices=[*BOXES])
    parser.add_argument("--picture", type=Path)
    given = parser.parse_args()
    os.environ |= ONE_THREAD
    keep_solids()
    factors = tuple(Factor(name, "m", *ends) for name, ends in BOXES[given.box].items())
    plain = StudyPlan(THROW, factors, DesignChoice("latin hypercube", runs=20), held_out=30)
    held = [design for design in plain.planned.designs if design.role == HELD_OUT]
    truth = {
        _place(design.values): evaluate_design(design.inputs | {"accuracy": TRUE_ACCURACY})
        for design in held
    }
    curves: dict[str, list[tuple[float, float]]] = {}
    print(
        f"{'mesh':>6}{'accuracy':>10}{'slopes':>8}{'runs':>6}{'CPU s':>8}  held out: largest (mean), %"
    )
    for slopes, counts in zip((False, True), RUNS[given.box], strict=True):
        for mesh, accuracy in WAYS:
            for count in counts:
                design = DesignChoice("latin hypercube", runs=count)
                plan = replace(plain, design=design, slopes=slopes, mesh=mesh, accuracy=accuracy)
                study = Study(plan, truth)
                largest, mean = study.errors
                name = f"{mesh}, {accuracy:g}" + (", slopes" if slopes else "")
                curves.setdefault(name, []).append((study.seconds, 100.0 * largest))
                kinds = {kind: study.kinds.count(kind) for kind in study.kinds}
                runs = sum(one.role == RUN for one in plan.planned.designs)
                print(
                    f"{mesh:>6}{accuracy:>10g}{'yes' if slopes else 'no':>8}{runs:>6}{study.seconds:>8.1f}"
                    f"  {100.0 * largest:.2f} ({100.0 * mean:.2f})  {kinds}",
                    flush=True,
                )
    if given.picture:
        draw(given.picture, curves)


def draw(path: Path, curves: dict[str, list[tuple[float, float]]]) -> None:
    """Draw the errors over the seconds, a color for each way, dashed with slopes."""
    with figure(path) as axes:
        for number, (name, points) in enumerate(curves.items()):
            seconds, errors = zip(*sorted(points), strict=True)
            color, line = (
                order_line_style(number % len(WAYS)).color,
                "--" if number >= len(WAYS) else "-",
            )
            axes.plot(seconds, errors, line, marker="o", color=color, label=name)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("processor time of the runs [s]")
        axes.set_ylabel("largest error of $e_n$ at held-out designs [%]")
        legend_inside(axes)


if __name__ == "__main__":
    main()

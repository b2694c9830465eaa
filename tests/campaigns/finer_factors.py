"""Factors of stress concentration with half the element sizes of the rule's mesh.

Run by hand: ``python tests/campaigns/finer_factors.py`` (four minutes on one core). It prints what
tests/validation/test_element_factors.py holds as `FINER`: after a change of that file's throws, or of how
stresses are read from a mesh.
"""

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from fem import fillet_peaks, fillet_stress
from validation.test_element_factors import THROWS, factors

FINER, ACROSS_WEB = 2.0, 9.0


def halve_sizes() -> None:
    """Ask for half the sizes at fillets and oil holes, and for nine elements across the web."""
    wished = fillet_peaks.WISHED_SIZE / FINER
    fillet_peaks.WISHED_SIZE = fillet_stress.WISHED_SIZE = wished
    fillet_peaks.WISHED_ACROSS = ACROSS_WEB
    fillet_stress.RULE_FINE = 0.5 * math.pi / wished
    fillet_stress.MOST_RULE_UNKNOWNS = 1_500_000
    fillet_stress.MOST_RULE_MESHES = 2


def main() -> None:
    """Print the factors of each throw, and what its meshes are like."""
    ruled = {name: factors(name, 0.05)[0] for name in THROWS}
    halve_sizes()
    for name in THROWS:
        stresses, values = factors(name, 0.2)
        for own, fine in zip(ruled[name].meshings, stresses.meshings, strict=True):
            assert fine.layers[0] < 0.85 * own.layers[0]
            assert fine.size_share < 0.85 * own.size_share
        nodes = len(stresses.loaded.mesh.points) / len(ruled[name].loaded.mesh.points)
        assert nodes > 2.5
        print(f"{name}, {nodes:.2g} times the nodes:", values, flush=True)


if __name__ == "__main__":
    main()

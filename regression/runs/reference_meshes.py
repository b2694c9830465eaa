"""The meshes that are moved in a study: made by the coordinator, and sent to workers with designs."""

import hashlib
import pickle
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from crankbase.errors import MeshError
from fem.moved_mesh import ReferenceMesh, make_reference
from geometry.throw import CrankThrow
from regression.records import MOVED, content_key

# Of one worker: designs come class by class, mostly.
KEPT = 4


class ReferenceMeshes:
    """Reference meshes by what designs ask for, each made when it is first needed."""

    def __init__(self) -> None:
        self._made: dict[str, tuple[bytes, str]] = {}

    def of(self, inputs: Mapping[str, Any]) -> bytes:
        """Return the mesh that a design's is moved from, as `opened` reads it; empty where there is none."""
        return self._of(inputs)[0]

    def digest(self, inputs: Mapping[str, Any]) -> str:
        """Return a hash of that mesh, "" where there is none: another mesher makes another one."""
        return self._of(inputs)[1]

    def _of(self, inputs: Mapping[str, Any]) -> tuple[bytes, str]:
        if MOVED not in inputs:
            return b"", ""
        key = content_key(inputs[MOVED])
        if key not in self._made:
            try:
                reference = make_reference(
                    CrankThrow(**inputs[MOVED]["throw"]), inputs[MOVED]["paths"]
                )
                self._made[key] = pickle.dumps(reference), mesh_digest(reference)
            except MeshError:  # its designs are meshed anew
                self._made[key] = b"", ""
        return self._made[key]


def mesh_digest(reference: ReferenceMesh) -> str:
    """Return a hash of a reference's mesh, without the nodes' places, which machines round differently."""
    return hashlib.sha256(reference.mesh.elements.tobytes()).hexdigest()[:12]


@lru_cache(KEPT)
def opened(content: bytes) -> ReferenceMesh:
    """Read a reference mesh that the coordinator has sent."""
    reference: ReferenceMesh = pickle.loads(content)
    return reference

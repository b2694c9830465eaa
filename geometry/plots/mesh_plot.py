"""The surface of a mesh in parallel projection on the axes of a diagram."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from crankbase.diagrams import GRAY, new_axes, write_title
from crankbase.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

OUTSIDE, CUT = (0.78, 0.84, 0.90), (0.96, 0.80, 0.60)
LINE, LINE_WIDTH = "#44525f", 0.25
# A face that looks past the light has this share of its color.
DARKEST = 0.7
LIGHT = (-0.45, 0.65, 1.0)  # to the right, up and towards the eye of the view
ARROW = 0.14  # length of the frame's arrows as a share of the view's width


def plot_mesh(
    axes: "Axes | None",
    points: Array,
    outside: Integers,
    cuts: Mapping[str, Integers],
    eye: Array,
    title: str,
) -> "Axes":
    """Draw the facets that look towards the eye, the farthest first.

    Parameters
    ----------
    points : (n, 3) array
        [m]
    outside : (k, 3) array of int
        Corners of the facets, counterclockwise from outside.
    cuts : mapping of str to (k, 3) array of int
        Facets on planes of symmetry, by the plane's name.
    eye : (3,) array
        Direction to the eye.

    Raises
    ------
    InputError
        If the direction is not three finite numbers, or along y.
    """
    from matplotlib.collections import PolyCollection
    from matplotlib.patches import Patch

    frame = view_frame(eye)
    facets = np.concatenate([outside, *cuts.values()])
    is_cut = np.arange(len(facets)) >= len(outside)
    seen = points @ frame.T  # to the right, up, towards the eye
    corners = seen[facets]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    front = np.flatnonzero(normals[:, 2] > 0.0)
    order = front[np.argsort(corners[front, :, 2].mean(axis=1), kind="stable")]
    light = np.array(LIGHT) / np.linalg.norm(LIGHT)
    bright = DARKEST + (1.0 - DARKEST) * np.clip(normals[order] @ light, 0.0, 1.0)
    colors = np.where(is_cut[order, None], CUT, OUTSIDE) * bright[:, None]

    axes = new_axes(axes, width=6.4, height=5.6)
    axes.add_collection(
        PolyCollection(
            list(corners[order, :, :2]), facecolors=colors, edgecolors=LINE, linewidths=LINE_WIDTH
        )
    )
    low, high = seen[:, :2].min(axis=0), seen[:, :2].max(axis=0)
    margin = 0.04 * float(np.max(high - low))
    _draw_frame(axes, frame, low - margin, float(high[0] - low[0]))
    axes.set_xlim(low[0] - 4.0 * margin, high[0] + margin)
    axes.set_ylim(low[1] - 4.0 * margin, high[1] + margin)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_xlabel("across the view [m]")
    axes.set_ylabel("up the view [m]")
    write_title(axes, title)
    if cuts:
        cut = Patch(facecolor=CUT, edgecolor=LINE, label=f"cut: {', '.join(cuts)}")
        axes.legend(
            frameon=False, handles=[cut], fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0)
        )
    return axes


def view_frame(eye: Array) -> Array:
    """Directions to the right, up and towards the eye (3, 3), the crank upright.

    Raises
    ------
    InputError
        If the direction to the eye is not three finite numbers, or along y.
    """
    usable = eye.shape == (3,) and bool(np.all(np.isfinite(eye)))
    right = np.cross((0.0, 1.0, 0.0), eye) if usable else np.zeros(3)
    if float(np.linalg.norm(right)) <= 1e-6 * float(np.linalg.norm(eye)):
        raise InputError(
            f"eye: given {eye.tolist()}; allowed are three finite numbers not all along y, because the crank "
            "is upright in the view."
        )
    towards = eye / np.linalg.norm(eye)
    right = right / np.linalg.norm(right)
    return np.array([right, np.cross(towards, right), towards])


def _draw_frame(axes: "Axes", frame: Array, corner: Array, width: float) -> None:
    """Draw the throw's directions x, y, z in a corner."""
    for name, direction in zip("xyz", frame.T, strict=True):
        tip = corner + ARROW * width * direction[:2]
        axes.annotate(
            "",
            xy=(float(tip[0]), float(tip[1])),
            xytext=(float(corner[0]), float(corner[1])),
            arrowprops={"arrowstyle": "-|>", "color": GRAY, "linewidth": 1.0, "shrinkB": 0.0},
        )
        text = corner + 1.25 * ARROW * width * direction[:2]
        axes.text(float(text[0]), float(text[1]), name, ha="center", va="center", fontsize=9)

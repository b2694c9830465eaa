"""Answers of the service: the models of its JSON, for the client and the description of the API."""

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

State = Literal["queued", "running", "done", "failed", "canceled"]
JobKind = Literal["analysis", "stress", "study", "engine"]
ENDED: tuple[State, ...] = ("done", "failed", "canceled")


class Answer(BaseModel):
    """An answer; later releases may add fields."""

    model_config = ConfigDict(extra="ignore", frozen=True)


class FieldError(Answer):
    """An error of one field; its name is empty where the message is about all of them."""

    field: str
    message: str


class Problem(Answer):
    """A problem (RFC 9457), with errors by field."""

    type: str
    title: str
    status: int
    detail: str
    errors: list[FieldError]


class Service(Answer):
    """The service and its version."""

    program: str
    version: str
    rows: int
    body: int


class Health(Answer):
    """Whether jobs run; what is wrong and since when (seconds since 1970); how many jobs wait and run.

    While something is wrong it is tried again, less and less often; "stopped" is tried with the next job.
    """

    state: Literal["ok", "retrying", "stopped"]
    problems: list[str]
    since: float | None
    queued: int
    running: int


class Shape(Answer):
    """Results of a throw's dimensions: its length and overlap [m], volume [m^3] and remarks."""

    length: float
    overlap: float
    volume: float
    remarks: list[str]
    pins: int
    solved_part: str


class ValidThrow(Answer):
    """A throw that can be built: its dimensions [SI], and as text for a file."""

    shape: Shape
    dimensions: dict[str, Any]
    material: dict[str, float]
    toml: str


class Formula(Answer):
    """One published formula's value."""

    name: str
    value: float
    unit: str
    valid: bool
    variant: str
    remarks: list[str]
    source: str


class Banded(Answer):
    """A value [SI] and the ends of its band, None where it has none."""

    value: float
    lower: float | None
    upper: float | None
    unit: str
    support: str


class Formulas(Answer):
    """All published formulas for a throw, and the law where it covers the throw."""

    axial: list[Formula]
    torsional: list[Formula]
    law: dict[str, Banded] | None
    left_out: list[dict[str, str]]
    not_used: list[str]


Components = list[float] | list[list[float]]
Bands = list[float | None] | list[list[float | None]]


class EndReaction(Answer):
    """Force [N] and moment [N m] of a support on the shaft, x y z in the throw frame, of one throw or many.

    Bands give the possible error of each; None where no band applies.
    """

    force: Components
    moment: Components
    force_band: Bands
    moment_band: Bands


class Reactions(Answer):
    """Reactions of both ends to a force on the pin; the axial motion of the ends is blocked."""

    support: str
    left: EndReaction
    right: EndReaction


class LawRange(Answer):
    """Range of a dimension in the law [m] with the others kept, and the ratio that ends it on each side."""

    low: float
    low_limit: str
    high: float
    high_limit: str


class Law(Answer):
    """Compliances by the law, each by response and support; reactions where a force was given.

    Slopes are per cent of e_n, ends pinned, for one per cent of each dimension, where they were wanted.
    """

    values: dict[str, Banded]
    ratio: float
    reactions: Reactions | None
    tier: str
    nearest_limit: str
    ranges: dict[str, LawRange] | None
    slopes: dict[str, float] | None
    not_used: list[str]
    remarks: list[str]


class ModelNames(Answer):
    """The available models."""

    models: list[str]


class ModelDescription(Answer):
    """Outputs of a model, and its range of throws [SI]."""

    name: str
    responses: dict[str, dict[str, Any]]
    ranges: dict[str, tuple[float, float]]
    categories: dict[str, list[str]]
    fixed: dict[str, float]
    labels: dict[str, str]
    units: dict[str, str]
    material: dict[str, Any]


class LookedUp(Answer):
    """A response of a model: one value, or a list of them for many throws; no band holds outside."""

    value: float | list[float | None] | None
    lower: float | list[float | None] | None
    upper: float | list[float | None] | None
    inside: bool | list[bool]
    unit: str
    symbol: str
    support: str
    remarks: list[str]
    band: str


class Lookups(Answer):
    """Responses of a model by name, and why others are left out; reactions where a force was given."""

    rows: int | None
    responses: dict[str, LookedUp]
    refused: dict[str, str]
    reactions: Reactions | None


class CheckedText(Answer):
    """A valid file, as ``crankfem check --json`` reports it."""

    kind: str
    valid: bool
    commands: list[str]
    remarks: list[str]
    warnings: list[str]
    dimensions: list[dict[str, Any]] | None
    throw: dict[str, Any] | None
    material: dict[str, float] | None
    record: dict[str, Any]


class Job(Answer):
    """A job and how far it is; times in seconds since 1970, designs of its study counted."""

    id: str
    kind: JobKind
    title: str
    state: State
    step: str
    finished: int
    total: int
    notes: list[str]
    problem: Problem | None
    created: float
    started: float | None
    ended: float | None
    attempts: int
    files: list[str]


class Jobs(Answer):
    """Jobs, the newest first."""

    jobs: list[Job]

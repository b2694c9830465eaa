"""A client of the service that ``crankfem serve`` starts, for other programs; no extra package is needed.

Quantities are numbers in SI units or texts with units; results are in SI units.
"""

import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar
from urllib.error import HTTPError, URLError
from urllib.parse import quote
from urllib.request import ProxyHandler, Request, build_opener

from crankbase.errors import InputError
from crankbase.input_file import not_a_file
from crankfem.satellites.service.answers import (
    ENDED,
    Answer,
    CheckedText,
    Formulas,
    Job,
    Jobs,
    Law,
    Lookups,
    ModelDescription,
    ModelNames,
    Problem,
    ValidThrow,
)

__all__ = ["Client", "RefusedError"]

Told = TypeVar("Told", bound=Answer)
Values = Mapping[str, Any]
LOOK = 0.2  # seconds between two looks at a job


class RefusedError(RuntimeError):
    """The service refuses a request for another reason than wrong input, or cannot be reached.

    Attributes
    ----------
    status : int
        Of HTTP; 0 without a response.
    retry_after : float or None
        Seconds after which to try again.
    """

    def __init__(self, detail: str, status: int = 0, retry_after: float | None = None) -> None:
        super().__init__(detail)
        self.status, self.retry_after = status, retry_after


@dataclass(frozen=True)
class Client:
    """A client of the service.

    Parameters
    ----------
    address : str
        As printed by ``crankfem serve``.
    key : str, optional
        If the service requires one.
    seconds : float
        Longest wait for a response [s].

    Examples
    --------
    ``Client().lookup("model", {"web_width": "300 mm"}).responses["axial_compliance"].value``
    """

    address: str = "http://127.0.0.1:8765"
    key: str | None = None
    seconds: float = 60.0

    def validate(self, throw: Values, material: Values | None = None) -> ValidThrow:
        """Check a throw, and return the quantities that follow from its dimensions.

        Raises
        ------
        InputError
            With a sentence for each wrong field; this holds for all methods.
        RefusedError
            If the service refuses, or cannot be reached; this holds for all methods.
        """
        return self._post(ValidThrow, "throws/validate", throw=throw, material=material)

    def outline(self, throw: Values, view: str = "side") -> str:
        """Return the side or front view of a throw as SVG."""
        return self._ask("throws/outline", {"throw": throw, "view": view}).decode()

    def formulas(
        self, throw: Values, *, gamma_deg: float = 180.0, material: Values | None = None
    ) -> Formulas:
        """Evaluate all published formulas for a throw."""
        return self._post(
            Formulas, "throws/formulas", throw=throw, gamma_deg=gamma_deg, material=material
        )

    def law(
        self,
        throw: Values,
        *,
        pin_force: Sequence[float | str] | None = None,
        support: str = "pinned",
        gamma_deg: float | None = None,
        left_gamma_deg: float | None = None,
        material: Values | None = None,
        ranges: bool = False,
        slopes: bool = False,
    ) -> Law:
        """Evaluate the law: compliances, c and, with a force on the pin, reactions; no finite elements.

        With `ranges` also the law's range in each dimension, the others kept; with `slopes` those of e_n.
        """
        return self._post(
            Law,
            "throws/law",
            throw=throw,
            pin_force=pin_force,
            support=support,
            gamma_deg=gamma_deg,
            left_gamma_deg=left_gamma_deg,
            material=material,
            ranges=ranges,
            slopes=slopes,
        )

    def analyze_throw(self, throw: Values, **options: Any) -> Job:
        """Start the analysis of a throw by finite elements.

        Parameters
        ----------
        throw : mapping
        **options
            ``material``, ``accuracy``, ``gamma_deg``, ``left_gamma_deg``, ``pin_force``, ``stress``.
        """
        return self._post(Job, "throws/analysis", throw=throw, **options)

    def analyze_stress(self, throw: Values, **options: Any) -> Job:
        """Start the calculation of the stresses at a throw's fillets; with ``material`` and ``accuracy``."""
        return self._post(Job, "throws/stress", throw=throw, **options)

    def models(self) -> list[str]:
        """Return the names of the available models."""
        return self._get(ModelNames, "models").models

    def describe_model(self, name: str) -> ModelDescription:
        """Describe the responses of a model, and its range of throws."""
        return self._get(ModelDescription, f"models/{quote(name, safe='')}")

    def lookup(
        self,
        model: str,
        dimensions: Values | None = None,
        *,
        throw: Values | None = None,
        material: Values | None = None,
        responses: Sequence[str] | None = None,
        pin_force: Sequence[float | str] | None = None,
        support: str = "pinned",
        gamma_deg: float | None = None,
        strict: bool = False,
    ) -> Lookups:
        """Look responses up in a model, for one throw or, if dimensions are lists, for many.

        Parameters
        ----------
        material : mapping, optional
            Of the throws; that of the model by default.
        """
        asked = {
            "dimensions": dict(dimensions or {}),
            "throw": throw,
            "material": material,
            "responses": None if responses is None else list(responses),
            "pin_force": pin_force,
            "support": support,
            "gamma_deg": gamma_deg,
            "strict": strict,
        }
        return self._post(Lookups, f"models/{quote(model, safe='')}/lookup", **asked)

    def check_file(self, path: str | Path, *tables: str | Path) -> CheckedText:
        """Check a file together with the tables that it names."""
        return self._post(CheckedText, "files/check", **_upload(path, tables))

    def run_study(self, path: str | Path, *tables: str | Path) -> Job:
        """Start the study of a file."""
        return self._post(Job, "studies", **_upload(path, tables))

    def run_engine(self, path: str | Path, *tables: str | Path) -> Job:
        """Start the run of a whole engine file."""
        return self._post(Job, "engines", **_upload(path, tables))

    def jobs(self) -> list[Job]:
        """Return the newest jobs."""
        return self._get(Jobs, "jobs").jobs

    def job(self, name: str) -> Job:
        """Return a job in its present state."""
        return self._get(Job, f"jobs/{quote(name, safe='')}")

    def follow(self, job: Job) -> Iterator[Job]:
        """Yield a job at each of its changes, until it has ended."""
        last = None
        while True:
            now = self.job(job.id)
            if now != last:
                yield now
            if now.state in ENDED:
                return
            last = now
            time.sleep(LOOK)

    def result(self, job: Job) -> dict[str, Any]:
        """Wait for a job, and return its numbers.

        Raises
        ------
        RefusedError
            If it failed or was canceled.
        """
        *_, last = self.follow(job)
        if last.state != "done":
            detail = f"The job is {last.state}." if last.problem is None else last.problem.detail
            raise RefusedError(detail)
        content: dict[str, Any] = json.loads(self._ask(f"jobs/{job.id}/result"))
        return content

    def cancel(self, job: Job) -> Job:
        """Cancel a job."""
        return Job.model_validate_json(self._ask(f"jobs/{job.id}/cancel", {}))

    def file(self, job: Job, name: str) -> bytes:
        """Return a file of a job, by one of the names in its ``files``."""
        return self._ask(f"jobs/{job.id}/files/{quote(name)}")

    def _get(self, kind: type[Told], path: str) -> Told:
        return kind.model_validate_json(self._ask(path))

    def _post(self, kind: type[Told], path: str, **asked: Any) -> Told:
        return kind.model_validate_json(self._ask(path, asked))

    def _ask(self, path: str, asked: Values | None = None) -> bytes:
        headers = {"Content-Type": "application/json"}
        if self.key is not None:
            headers["Authorization"] = f"Bearer {self.key}"
        body = None if asked is None else json.dumps(asked, allow_nan=False).encode()
        request = Request(f"{self.address.rstrip('/')}/api/{path}", body, headers)
        try:
            # The service is asked directly, whatever proxies are there for the web.
            with build_opener(ProxyHandler({})).open(request, timeout=self.seconds) as answer:
                content: bytes = answer.read()
                return content
        except HTTPError as error:
            raise _refusal(error) from None
        except (URLError, OSError) as error:
            reason = getattr(error, "reason", error)
            raise RefusedError(
                f"{self.address}: the service cannot be reached ({reason})."
            ) from None


def _refusal(error: HTTPError) -> Exception:
    try:
        problem = Problem.model_validate_json(error.read())
    except ValueError:
        return RefusedError(f"The service answered {error.code}.", error.code)
    if error.code == 422:
        sentences = [error_of_field.message for error_of_field in problem.errors] or [
            problem.detail
        ]
        return InputError("\n".join(sentences))
    after = error.headers.get("Retry-After")
    return RefusedError(problem.detail, error.code, None if after is None else float(after))


def _upload(path: str | Path, tables: Sequence[str | Path]) -> dict[str, Any]:
    return {
        "name": Path(path).name,
        "text": _text(path),
        "tables": {Path(table).name: _text(table) for table in tables},
    }


def _text(path: str | Path) -> str:
    if (entry := not_a_file(Path(path))) is not None:
        raise InputError(f"{path}: {entry}.")
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as text ({error}).") from None

"""The queue of waiting designs, with the number of attempts of each."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from regression.records import Outcome

# Claims a design: True if it is to be computed, False while another program computes it, None once it is
# finished.
Claim = Callable[[str], bool | None]

# A design is tried once more after its worker is lost, then set aside.
TRIES = 2


class WorkQueue:
    """Designs to compute, handed out one by one.

    Parameters
    ----------
    designs : iterable of (key, inputs)
    claim : callable, optional
        Called with a key before its design is assigned; by default every design is.
    """

    def __init__(
        self, designs: Iterable[tuple[str, Mapping[str, Any]]], claim: Claim | None = None
    ) -> None:
        self._claim: Claim = claim or (lambda _: True)
        self._inputs = dict(designs)
        self._waiting = deque(self._inputs)
        self._tries = dict.fromkeys(self._inputs, 0)

    def __len__(self) -> int:
        """Count the designs that wait."""
        return len(self._waiting)

    def next_request(self) -> dict[str, Any] | None:
        """Return the next design as a request to a worker; None if none is available now."""
        for _ in range(len(self._waiting)):
            key = self._waiting.popleft()
            claimed = self._claim(key)
            if claimed:
                self._tries[key] += 1
                return {"key": key, "inputs": self._inputs[key]}
            if claimed is False:
                self._waiting.append(key)
        return None

    def outcome(self, answer: Mapping[str, Any], worker: str) -> Outcome:
        """Make the outcome from a worker's response."""
        return self._outcome(
            answer["key"],
            responses=answer.get("responses"),
            reason=answer.get("reason"),
            seconds=answer["seconds"],
            errors=answer.get("errors") or {},
            unknowns=answer.get("unknowns"),
            worker=worker,
        )

    def lost(self, key: str, reason: str, seconds: float, worker: str) -> Outcome | None:
        """Take back a design whose worker is lost: None if it will be tried again, else its outcome."""
        if self._tries[key] < TRIES:
            self._waiting.append(key)
            return None
        return self._outcome(
            key, responses=None, reason=reason, seconds=seconds, lost=True, worker=worker
        )

    def _outcome(self, key: str, **found: Any) -> Outcome:
        return Outcome(key=key, inputs=self._inputs[key], attempts=self._tries[key], **found)

"""The whole API against its own description, with requests that fit it and requests that do not."""

import json

import pytest
from hypothesis import HealthCheck, given, settings

schemathesis = pytest.importorskip("schemathesis", reason="needs crankfem[test]")

# Requests for each path and method. One that fits the description may still be refused: dimensions must fit
# each other, and names must be there.
EXAMPLES = 30
CHECKS = (
    "not_a_server_error",
    "status_code_conformance",
    "content_type_conformance",
    "response_headers_conformance",
    "response_schema_conformance",
    "negative_data_rejection",
)
# These begin jobs: they are asked less often.
JOBS = ("/api/throws/analysis", "/api/throws/stress", "/api/studies", "/api/engines")


@pytest.fixture(scope="module")
def operations(service):
    schema = schemathesis.openapi.from_url(f"{service.address}/api/openapi.json")
    return [found.ok() for found in schema.get_all_operations()]


@pytest.mark.further
@pytest.mark.parametrize("mode", ["POSITIVE", "NEGATIVE"])
def test_every_answer_is_as_described(service, operations, mode):
    checks = [schemathesis.checks.CHECKS.get_one(name) for name in CHECKS]
    kind = getattr(schemathesis.GenerationMode, mode)
    assert len(operations) >= 18
    answered = 0
    for operation in operations:
        if mode == "NEGATIVE" and not list(operation.body):
            continue

        @given(case=operation.as_strategy(generation_mode=kind))
        @settings(
            max_examples=6 if operation.path in JOBS else EXAMPLES,
            deadline=None,
            suppress_health_check=list(HealthCheck),
        )
        def ask(case):
            nonlocal answered
            case.call_and_validate(checks=checks, timeout=120)
            answered += 1

        ask()
    assert answered > 100
    assert "Traceback" not in service.log.read_text()


def test_the_description_names_every_field_with_its_unit(service):
    _, _, text = service.ask("/api/openapi.json")
    fields = json.loads(text)["components"]["schemas"]["CrankThrow"]["properties"]
    assert fields["crank_radius"]["description"] == "crank radius, half the stroke [m]"
    assert fields["left_web"]["anyOf"][0]["properties"]["thickness"]["anyOf"]

"""The routes that skip the framework: what they answer, and what they leave to it."""

import asyncio
import json

import pytest
from fastapi import APIRouter
from starlette.responses import PlainTextResponse

from crankbase.errors import InputError
from crankfem.service.asking import ProblemError
from crankfem.service.model_routes import QuickRoutes

routes = APIRouter()


@routes.post("/say/{word}")
async def say(request, word):
    if word == "nothing":
        raise ProblemError(404, "There is nothing.")
    if word == "wrong":
        raise InputError("word: given wrong; allowed is another.")
    if word == "broken":
        raise ValueError(word)
    return PlainTextResponse(f"{word} {len(await request.body())}")


async def framework(scope, receive, send):
    await PlainTextResponse("framework")(scope, receive, send)


def post(path, method="POST"):
    """Return status and body of a request that is answered, and the error that it raises."""
    sent = []

    async def receive():
        return {"type": "http.request", "body": b"four"}

    async def send(message):
        sent.append(message)

    scope = {"type": "http", "method": method, "path": path, "headers": []}
    error = None
    try:
        asyncio.run(QuickRoutes(framework, routes.routes)(scope, receive, send))
    except ValueError as raised:
        error = raised
    return sent[0]["status"], sent[1]["body"].decode(), error


def test_its_routes_are_answered_and_others_left():
    assert post("/say/word") == (200, "word 4", None)
    assert post("/say/word", "GET") == (200, "framework", None)
    assert post("/say/two/words") == (200, "framework", None)


@pytest.mark.parametrize(
    ("word", "status", "told"),
    [
        ("nothing", 404, "There is nothing."),
        ("wrong", 422, "word: given wrong; allowed is another."),
    ],
)
def test_refusals_are_problems(word, status, told):
    found, body, _ = post(f"/say/{word}")
    assert found == status
    assert json.loads(body)["detail"] == told


def test_a_fault_is_answered_and_raised_for_the_log():
    status, body, error = post("/say/broken")
    assert status == json.loads(body)["status"] == 500
    assert str(error) == "broken"

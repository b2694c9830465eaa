"""The routes that are called most often: their requests skip the framework between guard and function."""

from collections.abc import Sequence

from fastapi.routing import APIRoute
from starlette.requests import ClientDisconnect, Request
from starlette.types import ASGIApp, Receive, Scope, Send

from crankbase.errors import InputError
from crankfem.service.problems import ProblemError, answer_error, answer_fault


class QuickRoutes:
    """Calls the functions of some routes itself; an application answers everything else.

    Parameters
    ----------
    app : ASGI application
    routes : sequence of APIRoute
        For POST, their functions of a request and of the parts of its path. The application has them
        too, and describes them.
    """

    def __init__(self, app: ASGIApp, routes: Sequence[APIRoute]) -> None:
        self._app = app
        self._routes = [(route, route.path_regex.fullmatch, route.endpoint) for route in routes]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope.get("method") == "POST":
            for route, matched, function in self._routes:
                found = matched(scope["path"])
                if found is not None:
                    scope["route"] = route
                    request = Request(scope, receive)
                    try:
                        response = await function(request, **found.groupdict())
                    except (InputError, ProblemError) as error:
                        response = await answer_error(request, error)
                    except ClientDisconnect:
                        raise
                    except Exception as error:
                        response = await answer_fault(request, error)
                        await response(scope, receive, send)
                        raise  # for the log
                    await response(scope, receive, send)
                    return
        await self._app(scope, receive, send)

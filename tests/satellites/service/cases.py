"""What the core's tests of every command and file do with the service."""

# Of a command that reads files: a line of it. Its JSON is looked at here.
READS = {"serve": ("serve", "--key-file", "PATH")}
# What starts where only what is read and checked before is tried.
STARTS = {"serve": "crankfem.satellites.service.app.serve"}


def questions():
    from satellites.service import requests

    return requests.requests()


def asking(folder):
    from satellites.service import requests

    return requests.asking(folder)


# Of what is asked wrongly: the questions, and what gives one, in a folder.
ASKED = {"service": (questions, asking)}

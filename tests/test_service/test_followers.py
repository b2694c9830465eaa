"""Streams of progress: one look at a job serves all who follow it."""

import asyncio
import json
import time

import pytest

from crankfem.service import job_store
from crankfem.service.job_store import FULL, Followers, JobStore, StoreError


@pytest.fixture
def store(tmp_path):
    made = JobStore(tmp_path)
    yield made
    made.close()


def followed(store, name, change, count=1, stopping=lambda: False):
    """Follow a job by so many streams until all have ended; return the states that each was told."""

    async def stream(source):
        return [json.loads(text)["state"] async for text in source.follow(name)]

    async def run():
        source = Followers(store, stopping)
        changes = asyncio.create_task(change())
        async with asyncio.timeout(30.0):
            told = await asyncio.gather(*[stream(source) for _ in range(count)])
        await changes
        return told

    return asyncio.run(run())


@pytest.mark.slow
def test_every_follower_gets_every_change_and_the_end(store, monkeypatch):
    looks, looked = [], store.job
    monkeypatch.setattr(store, "job", lambda name: looks.append(name) or looked(name))
    name = store.add("study", "mine", {}, 20)

    async def change():
        await asyncio.sleep(0.4)
        store.change(name, state="running")
        await asyncio.sleep(0.4)
        store.settle(name, "done")

    began = time.monotonic()
    assert followed(store, name, change, 100) == [["queued", "running", "done"]] * 100
    assert len(looks) <= 2 + (time.monotonic() - began) / job_store.LOOK  # one for all of them


def test_a_store_that_cannot_be_read_for_a_while_ends_no_stream(store, monkeypatch):
    name, looked, full = store.add("study", "mine", {}, 20), store.job, [True]

    def fails(name):
        if full:
            raise StoreError(507, FULL)
        return looked(name)

    monkeypatch.setattr(store, "job", fails)

    async def change():
        await asyncio.sleep(0.3)
        full.clear()
        store.settle(name, "failed")

    assert followed(store, name, change) == [["failed"]]


def test_streams_end_with_the_job_s_record_and_with_the_service(store):
    name, ended = store.add("study", "mine", {}, 20), []

    async def remove():
        await asyncio.sleep(0.3)
        store.remove(name)

    assert followed(store, name, remove) == [["queued"]]
    name = store.add("study", "mine", {}, 20)

    async def end():
        await asyncio.sleep(0.3)
        ended.append(True)

    assert followed(store, name, end, stopping=lambda: bool(ended)) == [["queued"]]


@pytest.mark.slow
def test_a_follower_hears_from_time_to_time_that_nothing_changes(store, monkeypatch):
    monkeypatch.setattr(job_store, "PING", 0.2)
    name = store.add("study", "mine", {}, 20)

    async def change():
        await asyncio.sleep(1.0)
        store.settle(name, "canceled")

    (told,) = followed(store, name, change)
    assert set(told[:-1]) == {"queued"}
    assert 3 <= len(told[:-1]) <= 7

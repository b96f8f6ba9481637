"""Places that clients share."""

from __future__ import annotations

import threading

from mcml_service.processes.fair_queue import FairQueue


def test_who_waits_is_served_in_turn() -> None:
    turns = FairQueue(2)
    assert turns.take("a", 0)
    assert not turns.take("a", 0)
    assert turns.take("b", 0)
    order: list[str] = []
    begun = threading.Semaphore(0)

    def wait(client: str) -> None:
        begun.release()
        assert turns.take(client, 60)
        order.append(client)
        turns.give(client)

    threads = [threading.Thread(target=wait, args=(client,)) for client in "aaac"]
    for thread in threads:
        thread.start()
        begun.acquire()
    while turns.waiting.total() < 4:
        pass
    turns.give("b")
    threads[-1].join()
    assert order == ["c"]
    turns.give("a")
    for thread in threads:
        thread.join()
    assert order == ["c", "a", "a", "a"]


def test_who_left_is_passed_over() -> None:
    turns = FairQueue(2)
    held = turns.ask("a")
    left, waits, other = turns.ask("a"), turns.ask("a"), turns.ask("b")
    assert (held.done(), left.done(), waits.done(), other.done()) == (True, False, False, True)
    assert turns.waiting == {"a": 2}
    assert left.cancel()
    assert turns.waiting == {"a": 1}
    # Who has a place cannot leave the queue, but gives it back.
    assert not held.cancel()
    turns.give("a")
    assert waits.done()
    assert turns.held == 2
    turns.give("a")
    turns.give("b")
    assert (turns.held, turns.waiting.total()) == (0, 0)


def test_who_finds_a_place_at_once() -> None:
    """One client never has the last place."""
    turns = FairQueue(2)
    assert turns.has_place("a")
    turns.ask("a")
    assert (turns.has_place("a"), turns.has_place("b")) == (False, True)
    turns.ask("b")
    assert (turns.has_place("b"), turns.has_place("c")) == (False, False)
    turns.give("b")
    assert (turns.has_place("a"), turns.has_place("c")) == (False, True)

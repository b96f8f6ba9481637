"""How passwords are guessed: how often one may try, over all servers of a store, and which nobody may have."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from fastapi.testclient import TestClient

from mcml.errors import AttemptsError, RequestError
from mcml_service import passwords
from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.counting import count_attempt
from mcml_service.storage.database import Database
from mcml_service.storage.team.tables import attempt
from tests.builders import SECRET, one_kind

pytestmark = pytest.mark.usefixtures("quick_hashes")

API = "/api/v1"
HOME = "http://127.0.0.1:8000"
WORDS = "four words in a row"


def browser(database: Database) -> TestClient:
    """Somebody elsewhere, at a server of their own."""
    app = create_app(Settings(), database, lambda: SECRET)
    return TestClient(app, base_url=HOME, client=("10.0.0.7", 50_000), headers={"origin": HOME})


@pytest.fixture
def nobody(database: Database) -> TestClient:
    """A browser elsewhere; the store has an owner, kim."""
    with database.write() as tx:
        tx.accounts.add("kim", "owner", passwords.hash_password(WORDS, "kim"))
    return browser(database)


@pytest.fixture
def kim(database: Database, nobody: TestClient) -> TestClient:
    client = browser(database)
    assert client.post(f"{API}/session", json={"name": "kim", "password": WORDS}).status_code == 201
    return client


def form(client: TestClient, **fields: str) -> int:
    return client.post("/login", data=fields, follow_redirects=False).status_code


def test_guessing_has_an_end(nobody: TestClient) -> None:
    asked = {"name": "kim", "password": "wrong words in a row"}
    codes = [nobody.post(f"{API}/session", json=asked).status_code for _ in range(11)]
    assert codes == [403] * 10 + [429]
    refused = nobody.post(f"{API}/session", json={"name": "kim", "password": WORDS})
    assert refused.status_code == 429
    assert 1 <= int(refused.headers["retry-after"]) <= 60
    assert form(nobody, name="kim", password=WORDS) == 429


def test_guesses_at_all_servers_of_a_store_count_together(database: Database, nobody: TestClient) -> None:
    servers = [nobody, browser(database)]
    asked = {"name": "kim", "password": "wrong words in a row"}
    codes = [servers[number % 2].post(f"{API}/session", json=asked).status_code for number in range(11)]
    assert codes == [403] * 10 + [429]
    with database.read() as tx:
        kept = str(tx.connection.execute(attempt.select()).all())
    assert all(secret not in kept for secret in ("kim", "10.0.0.7", "wrong"))


def test_guesses_that_come_at_once_are_no_more(database: Database) -> None:
    def passes(_number: int) -> bool:
        try:
            count_attempt(database, {"address": "10.0.0.7"})
        except AttemptsError:
            return False
        return True

    with ThreadPoolExecutor(8) as threads:
        at_once = sum(threads.map(passes, range(24)))
    assert at_once <= 10
    assert at_once + sum(map(passes, range(11))) == 10
    with database.write() as tx:
        tx.connection.execute(attempt.update().values(expires=time.time() - 1))
    assert passes(0), "what is over counts no more"
    with database.read() as tx:
        assert len(tx.connection.execute(attempt.select()).all()) == 1


def test_the_current_password_is_not_guessed_in_a_session(kim: TestClient) -> None:
    asked = {"current": "wrong words in a row", "new": "five other words in a row"}
    codes = [kim.put(f"{API}/account/password", json=asked).status_code for _ in range(11)]
    assert codes == [403] * 10 + [429]
    right = kim.put(f"{API}/account/password", json=asked | {"current": WORDS})
    assert right.status_code == 429
    assert 1 <= int(right.headers["retry-after"]) <= 60


@pytest.mark.parametrize("common", ["qwertyuiop", "Password123", "1Q2W3E4R5T", "manchester"])
@one_kind
def test_common_passwords_are_refused(kim: TestClient, nobody: TestClient, common: str) -> None:
    refused = kim.put(f"{API}/account/password", json={"current": WORDS, "new": common})
    assert refused.status_code == 422
    assert "tried first" in refused.json()["detail"]
    code = kim.post(f"{API}/invitations", json={"role": "reader"}).json()["code"]
    joined = nobody.post(f"{API}/session", json={"invitation": code, "name": "lee", "password": common})
    assert joined.status_code == 422


GUESSED = [
    *("ann ann ann", "ANN Ann ann", "nna nna nna", "ann.ann.ann", "ann123456789", "ann2024!!!", "annannannann1"),
    *("aaaaaaaaaa", "abcabcabcabc", "password password", "pass-word-pass-word", "ab ab ab ab ab", "!!!!!!!!!!"),
    *("qwertyuiop12", "asdfghjkl;", "9876543210", "1qaz2wsx3edc", "1122334455", "abcdefghijkl", "azerty qwertz"),
]
"""For somebody called ann."""
WELL_CHOSEN = ["correct horse battery staple", "banana tree", "hello kitty", "mississippi river", "k3#vT9!qLm", WORDS]


def test_names_repetitions_and_rows_of_keys_are_no_passwords(quick_hashes: None) -> None:
    for password in GUESSED:
        with pytest.raises(RequestError, match=r"easy to guess|tried first"):
            print(password, passwords.hash_password(password, "ann"))
    for password in WELL_CHOSEN:
        assert passwords.opens(password, passwords.hash_password(password, "ann"))
    with pytest.raises(RequestError, match="easy to guess"):
        passwords.hash_password("Jo Anne jo anne 1", "jo anne")


@one_kind
def test_the_api_refuses_what_is_guessed(kim: TestClient) -> None:
    refused = kim.put(f"{API}/account/password", json={"current": WORDS, "new": "kim kim kim kim"})
    assert refused.status_code == 422
    assert "easy to guess" in refused.json()["detail"]


def test_of_common_passwords_those_are_known_that_are_long_enough() -> None:
    """OWASP ASVS 5.0, 6.2.4: the 3,000 most common of those that one could have."""
    known = passwords._common()
    assert len(known) == 5000
    assert all(passwords.LEAST <= len(one) <= passwords.MOST and one == one.casefold() for one in known)


def test_who_gets_in_begins_anew(nobody: TestClient) -> None:
    for _ in range(2):
        for _ in range(8):
            assert form(nobody, name="kim", password="wrong words in a row") == 403
        assert form(nobody, name="kim", password=WORDS) == 303

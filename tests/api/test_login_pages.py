"""The sign-in pages speak the language that a browser asks for, in whole."""

from __future__ import annotations

import ast
import html
import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from mcml.errors import AttemptsError
from mcml_service.api.login_pages import LoginPages
from mcml_service.api.login_words import choose_language, translate
from mcml_service.resources import login_words_path

TABLES: dict[str, dict[str, str]] = json.loads(login_words_path().read_text(encoding="utf-8"))
SERVICE = login_words_path().parent


def read_texts(module: ast.Module) -> Iterator[str]:
    """The texts of a module, with {} for each value."""
    for node in ast.walk(module):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield re.sub(r"\{\w+\}", "{}", node.value)
        elif isinstance(node, ast.JoinedStr):
            yield "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values)


@pytest.mark.parametrize(
    ("accepted", "language"),
    [
        ("", "en"),
        ("ko", "ko"),
        ("ja-JP,ja;q=0.9,en;q=0.8", "ja"),
        ("fr, ko;q=0.4, ja;q=0.5", "ja"),
        ("en-GB, ko;q=0.9", "en"),
        ("ko;q=0, ja;q=0.1", "ja"),
        ("KO-kr", "ko"),
        ("ko;q=much, *;q=0.5, ;;,", "en"),
    ],
)
def test_the_language_with_the_greatest_weight_is_taken(accepted: str, language: str) -> None:
    assert choose_language(accepted) == language


def test_all_languages_have_the_same_sentences_and_values() -> None:
    korean, japanese = TABLES["ko"], TABLES["ja"]
    assert korean.keys() == japanese.keys()
    for english in korean:
        values = sorted(re.findall(r"\{\w+\}", english))
        assert sorted(re.findall(r"\{\w+\}", korean[english])) == values, english
        assert sorted(re.findall(r"\{\w+\}", japanese[english])) == values, english


def test_each_translated_sentence_is_one_of_the_program() -> None:
    """A sentence that was reworded would stay English without a word."""
    sources = [*(SERVICE / "api").glob("*.py"), SERVICE / "passwords.py", SERVICE / "storage/team/accounts.py"]
    errors = Path(__file__).parents[2] / "mcml/errors.py"
    program = {text for path in [*sources, errors] for text in read_texts(ast.parse(path.read_text(encoding="utf-8")))}
    unknown = [text for text in TABLES["ko"] if re.sub(r"\{\w+\}", "{}", text) not in program]
    assert unknown == []


@pytest.mark.parametrize("language", ["ko", "ja"])
def test_pages_have_no_english_sentence_left(language: str) -> None:
    pages = LoginPages(language, "Campus")
    wrong = pages.explain(AttemptsError(30))
    assert "30" in wrong
    shown = [pages.login(wrong, status=429), pages.join("invitation", "code", "You are invited to this repository.")]
    shown += [pages.follow("code", first=first) for first in (True, False)]
    for page in shown:
        text = html.unescape(bytes(page.body).decode())
        assert f'<html lang="{language}">' in text
        for english, translated in TABLES[language].items():
            assert f">{english}<" not in text, english
            assert f">{english} <" not in text, english
            assert english == translated or "{" in english or len(english) < 20 or english not in text
    assert "Campus" in bytes(shown[0].body).decode()


def test_a_wrong_password_is_told_in_the_language(client: TestClient) -> None:
    form = {"name": "kim", "password": "not this one"}
    for language, sentence in (("en", "Name or password is wrong."), ("ja", "名前またはパスワードが違います。")):
        answer = client.post("/login", data=form, headers={"accept-language": language})
        assert answer.status_code == 403
        assert sentence in answer.text


def test_names_in_messages_are_kept_and_escaped() -> None:
    assert translate("ja", "Sign in with Campus") == "Campus でサインイン"
    assert translate("ja", "Sign in with a token") == "トークンでサインイン"
    assert translate("ko", "The name '<b>' is taken.") == "'<b>' 이름은 이미 사용 중입니다."
    page = bytes(LoginPages("ko", None).login("The name '<b>' is taken.").body).decode()
    assert "&lt;b&gt;" in page
    assert "<b>" not in page

"""A place in the tokens of an expression."""

from __future__ import annotations

from mcml.errors import Place, QueryError
from mcml_service.xpath.language.tokens import Token, tokens


class Cursor:
    """text: the expression."""

    def __init__(self, text: str) -> None:
        self._tokens = tokens(text)
        self._place = 0
        self._next = self._tokens[0]

    def _advance(self) -> Token:
        token = self._next
        self._place += 1
        self._next = self._tokens[min(self._place, len(self._tokens) - 1)]
        return token

    def _at(self, *symbols: str) -> bool:
        return self._next.kind == "symbol" and self._next.text in symbols

    def _accept(self, symbol: str) -> bool:
        if self._at(symbol):
            self._advance()
            return True
        return False

    def _expect(self, symbol: str) -> None:
        if not self._accept(symbol):
            raise self._unexpected(f"{symbol!r} is missing")

    def _follows(self, symbol: str, ahead: int = 1) -> bool:
        """Whether this symbol follows the next token."""
        after = self._tokens[min(self._place + ahead, len(self._tokens) - 1)]
        return after.kind == "symbol" and after.text == symbol

    def _at_word(self, *words: str) -> bool:
        return self._next.kind == "name" and self._next.text in words

    def _word(self, word: str) -> None:
        if not self._at_word(word):
            raise self._unexpected(f"{word!r} is missing")
        self._advance()

    def _end(self) -> int:
        return self._tokens[self._place - 1].end

    def _unexpected(self, wanted: str) -> QueryError:
        token = self._next
        if token.kind == "end":
            last = self._tokens[self._place - 1] if self._place else token
            return QueryError(f"the expression ends early: {wanted}", at=Place(column=last.start + 1))
        if token.text == ":":
            return QueryError("a prefix cannot be used here", at=Place(column=token.start + 1))
        return QueryError(f"unexpected {token.text!r}: {wanted}", at=Place(column=token.start + 1))

    def _variable_name(self) -> str:
        if self._next.kind != "name":
            raise self._unexpected("the name of a variable is missing")
        return self._advance().text

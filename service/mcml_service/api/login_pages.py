"""The pages that let a browser in, in the language that it asks for."""

from __future__ import annotations

import html
from urllib.parse import urlencode

from fastapi.responses import HTMLResponse

from mcml.errors import McmlError
from mcml_service.api.login_words import choose_language, translate
from mcml_service.api.page import page

LOGIN_PATH = "/login"
TITLE = "MCML Repository"
_ADMINISTRATOR = "The administrator of the server invites people and creates tokens: {invite}, {token}."


class LoginPages:
    """The pages for one browser.

    accepted: its `Accept-Language`. provider: name of the OpenID provider for signing in, None without one.
    """

    def __init__(self, accepted: str, provider: str | None) -> None:
        self.language = choose_language(accepted)
        self.provider = provider

    def login(self, why: str, *, status: int = 200, then: str = "/") -> HTMLResponse:
        """The sign-in page. why: the reason for it, in English. then: the path that follows."""
        field = self._hidden("then", then)
        by_password = self._form(field + self._name("24") + self._password("current-password"), "Sign in")
        token = self._input("Token", 'name="token" type="password" autocomplete="off" size="52"')
        commands = {"invite": "<code>mcml account invite</code>", "token": "<code>mcml token add NAME</code>"}
        return self._page(
            f"""{self._head(why)}
{by_password}{self._by_provider(then=then)}
<details><summary>{self._text("Sign in with a token")}</summary>
{self._form(field + token, "Open")}</details>
<p>{self._text(_ADMINISTRATOR).format(**commands)}</p>""",
            status,
        )

    def join(self, kind: str, code: str, why: str, *, status: int = 200) -> HTMLResponse:
        """The page on which an account is made. kind, code: the "invitation" or "link" that allows it."""
        return self._page(self._join(kind, code, why), status)

    def follow(self, link: str, *, first: bool) -> HTMLResponse:
        """The page of a sign-in link. first: the repository has no account yet, so the page offers to make it."""
        once = f"<p>{self._text('This link opens the repository once, in this browser.')}</p>"
        form = self._form(self._hidden("link", link), "Open")
        if not first:
            return self._page(f"<h1>{TITLE}</h1>{once}{form}", 200)
        why = "This server has no owner yet. Create the first account; it becomes the owner."
        other = f"<h2>{self._text('Or without an account')}</h2>{once}{form}"
        return self._page(self._join("link", link, why) + other, 200)

    def explain(self, error: McmlError) -> str:
        """The fault and its remedy, in the language of the pages."""
        return " ".join(translate(self.language, text) for text in (error.what, error.remedy) if text)

    def _join(self, kind: str, code: str, why: str) -> str:
        fields = self._hidden(kind, code) + self._name("24", 'maxlength="64" required')
        fields += self._password("new-password", 'minlength="10" maxlength="256" required')
        rule = self._text("A password has ten characters or more. Revisions show the name.")
        return (
            f"{self._head(why)}{self._form(fields, 'Create account')}<p>{rule}</p>{self._by_provider(**{kind: code})}"
        )

    def _page(self, body: str, status: int) -> HTMLResponse:
        return page(TITLE, body, status=status, forms=True, language=self.language)

    def _text(self, sentence: str) -> str:
        return html.escape(translate(self.language, sentence))

    def _head(self, why: str) -> str:
        return f"<h1>{TITLE}</h1><p>{self._text(why)}</p>"

    def _form(self, fields: str, button: str) -> str:
        return f'<form method="post" action="{LOGIN_PATH}">{fields}<button>{self._text(button)}</button></form>'

    def _hidden(self, name: str, value: str) -> str:
        return f'<input type="hidden" name="{name}" value="{html.escape(value)}">'

    def _input(self, label: str, attributes: str) -> str:
        return f"<p><label>{self._text(label)} <input {attributes}></label></p>"

    def _name(self, size: str, further: str = "") -> str:
        return self._input("Name", f'name="name" autocomplete="username" size="{size}" autofocus {further}')

    def _password(self, kind: str, further: str = "") -> str:
        return self._input("Password", f'name="password" type="password" autocomplete="{kind}" size="24" {further}')

    def _by_provider(self, **carried: str) -> str:
        """The link to the provider, with values that come back from there."""
        if self.provider is None:
            return ""
        address = html.escape(f"{LOGIN_PATH}/openid?{urlencode(carried)}")
        return f'<p class="other"><a href="{address}">{self._text(f"Sign in with {self.provider}")}</a></p>'

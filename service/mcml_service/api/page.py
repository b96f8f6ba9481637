"""The API reference and plain pages. Everything is served from here."""

from __future__ import annotations

import html
from pathlib import Path

import fastapi_offline
from fastapi import APIRouter
from fastapi.responses import FileResponse, HTMLResponse

from mcml.errors import NotFoundError, kind_name
from mcml.resources import dtd_path
from mcml_service.actions.checking.describe_problem import STATUS_OF
from mcml_service.api.policy import page_policy

router = APIRouter(include_in_schema=False)

_SWAGGER = Path(fastapi_offline.__file__).parent / "static"
_ASSETS = ("swagger-ui-bundle.js", "swagger-ui.css", "favicon.png")

_REFERENCE = 'SwaggerUIBundle({url:"/openapi.json",dom_id:"#swagger-ui",deepLinking:true,validatorUrl:null})'

_STYLE = """
:root { color-scheme: dark light; --bg: #10141A; --panel: #171C24; --text: #E9EDF3; --dim: #97A3B3; --accent: #3FD0BC;
  --line: #2E3844; --edge: #6E7C8E }
@media (prefers-color-scheme: light) {
  :root { --bg: #F3F5F8; --panel: #fff; --text: #141A22; --dim: #566272; --accent: #0A7568; --line: #D3DAE3;
    --edge: #738091 }
}
body { margin: 0; background: var(--bg); color: var(--text);
  font: 14px/1.45 system-ui, "Segoe UI", Roboto, "Apple SD Gothic Neo", "Malgun Gothic", "Noto Sans KR", sans-serif }
body:lang(ja) { font-family: "Hiragino Sans", "Yu Gothic UI", "Noto Sans JP", Meiryo, sans-serif }
main { max-width: 1040px; margin: 0 auto; padding: 32px 24px }
h1 { font-size: 24px; margin: 0 0 4px }
h2 { font-size: 15px; margin: 28px 0 8px }
p { color: var(--dim); margin: 0 0 12px }
a { color: var(--accent) }
table { border-collapse: collapse; width: 100%; background: var(--panel) }
th, td { text-align: left; padding: 6px 10px; border-bottom: 1px solid var(--line); vertical-align: top }
th { color: var(--dim); font-weight: 600 }
.n { text-align: right; font-variant-numeric: tabular-nums }
input, button { font: inherit; color: var(--text); background: var(--panel); border: 1px solid var(--line);
  border-radius: 6px; padding: 7px 12px }
button { color: var(--bg); background: var(--accent); border-color: var(--accent); font-weight: 600; cursor: pointer }
main:has(form) { max-width: 360px; padding-top: 12vh }
label { display: block }
label input { display: block; box-sizing: border-box; width: 100%; margin: 4px 0 0 }
.other a { display: block; padding: 7px 12px; border: 1px solid var(--edge); border-radius: 6px; color: var(--text);
  text-align: center; text-decoration: none }
.other a:hover { background: var(--panel) }
p + button { margin-top: 4px; width: 100% }
details { margin: 20px 0; color: var(--dim) }
summary { cursor: pointer; margin-bottom: 12px }
input { border-color: var(--edge) }
@media (max-width: 700px) {
  table { display: block; overflow-x: auto }
}
:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px }
pre { background: var(--panel); padding: 12px; overflow: auto; border-radius: 6px }
"""


def page(title: str, body: str, *, status: int = 200, forms: bool = False, language: str = "en") -> HTMLResponse:
    """A page in the plain style. forms: it may send forms to this server. language: HTML's `lang`."""
    return HTMLResponse(
        f"""<!doctype html><html lang="{language}"><head><meta charset="utf-8"><title>{title}</title>
<meta name="viewport" content="width=device-width,initial-scale=1"><style>{_STYLE}</style></head><body><main>
{body}
</main></body></html>""",
        status,
        page_policy(styles=[_STYLE], forms=forms),
    )


@router.get("/docs")
def reference() -> HTMLResponse:
    """The API reference; nothing is loaded from elsewhere."""
    return HTMLResponse(
        f"""<!doctype html><html lang="en"><head><meta charset="utf-8"><title>MCML Repository: API reference</title>
<link rel="stylesheet" href="/docs/assets/swagger-ui.css"><link rel="icon" href="/docs/assets/favicon.png"></head>
<body><div id="swagger-ui"></div><script src="/docs/assets/swagger-ui-bundle.js"></script>
<script>{_REFERENCE}</script>
</body></html>""",
        headers=page_policy(["'self'"], ["'self'", _REFERENCE], "connect-src 'self'; img-src 'self' data:"),
    )


@router.get("/docs/assets/{name}")
def asset(name: str) -> FileResponse:
    if name not in _ASSETS:
        raise NotFoundError(f"There is no file {name!r}.")
    return FileResponse(_SWAGGER / name)


@router.get("/docs/problems")
def problems_page() -> HTMLResponse:
    """The kinds of problems, as `type` of a problem names them."""
    rows = "".join(
        f'<tr id="{kind_name(kind)}"><td>{html.escape(kind.__name__)}</td><td>{status}</td>'
        f"<td>{html.escape(kind.__doc__ or '')}</td></tr>"
        for kind, status in STATUS_OF.items()
    )
    return page("Problems", f"<h1>Problems</h1><table>{rows}</table>")


@router.get("/mcml.dtd")
def definition() -> FileResponse:
    """The definition of the language."""
    return FileResponse(dtd_path(), media_type="application/xml-dtd", filename="mcml.dtd")

"""The plain front page and the API reference, until the browser studio is built. Everything is served from here."""

from __future__ import annotations

import html
from pathlib import Path

import fastapi_offline
from fastapi import APIRouter, Request
from fastapi.responses import FileResponse, HTMLResponse

from service.actions.checking.describe_problem import STATUS_OF, slug
from service.api.policy import page_policy
from service.errors import NotFoundError
from service.mcml.elements import to_head
from service.motion.skeleton import Convention
from service.resources import dtd_path
from service.storage.documents import StoredDocument
from service.storage.filtering import DocumentFilter

router = APIRouter(include_in_schema=False)

_SWAGGER = Path(fastapi_offline.__file__).parent / "static"
_ASSETS = ("swagger-ui-bundle.js", "swagger-ui.css", "favicon.png")
_SHOWN = 200
_EXPORTS = {False: ("bvh", "asf-amc", "htr"), True: ("c3d", "trc")}
"""Formats that can hold a document, by whether it has markers in the place of a body."""

_REFERENCE = 'SwaggerUIBundle({url:"/openapi.json",dom_id:"#swagger-ui",deepLinking:true,validatorUrl:null})'

_STYLE = """
:root { color-scheme: dark light; --bg: #10141A; --panel: #171C24; --text: #E9EDF3; --dim: #97A3B3; --accent: #3FD0BC;
  --line: #2E3844 }
@media (prefers-color-scheme: light) {
  :root { --bg: #F3F5F8; --panel: #fff; --text: #141A22; --dim: #566272; --accent: #0A7568; --line: #D3DAE3 }
}
body { margin: 0; background: var(--bg); color: var(--text);
  font: 14px/1.45 system-ui, "Segoe UI", Roboto, "Apple SD Gothic Neo", "Malgun Gothic", "Noto Sans KR", sans-serif }
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
label input { margin: 0 10px; box-sizing: border-box; max-width: calc(100vw - 68px) }
@media (max-width: 700px) {
  table { display: block; overflow-x: auto }
  label input { display: block; margin: 4px 0 8px }
}
:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px }
pre { background: var(--panel); padding: 12px; overflow: auto; border-radius: 6px }
"""


@router.get("/")
def front_page(request: Request) -> HTMLResponse:
    """What is stored, and where to go from here."""
    with request.app.state.repository.database.read() as tx:
        found = tx.documents.page(DocumentFilter(), after=None, limit=_SHOWN, newest_first=True)
        total = tx.documents.count(DocumentFilter())
        names = {stored.key: {span.name: None for span in tx.spans.of(stored.key)} for stored in found}
        # Documents share skeletons: one of each is looked at.
        of_skeleton = {stored.skeleton: stored for stored in found}
        markers = {
            key: to_head(tx.heads.document(one)).skeleton.joints[0].convention is Convention.MARKER
            for key, one in of_skeleton.items()
        }
        counts = tx.spans.counts()
    base = html.escape(str(request.base_url).rstrip("/"))
    rows = "".join(_row(stored, list(names[stored.key]), markers[stored.skeleton]) for stored in found)
    more = "" if total <= _SHOWN else f"<p>The newest {_SHOWN} of {total:,} documents.</p>"
    example = counts[0][0] if counts else "walk"
    return page(
        "MCML Repository",
        f"""<h1>MCML Repository</h1>
<p>Motion capture in one open XML language. <a href="/docs">API reference</a> · <a href="/mcml.dtd">mcml.dtd</a> ·
<a href="/api/v1/formats">formats</a> · <a href="/api/v1/motion-names">motion names</a> ·
<a href="/api/v1/joint-names">joint names</a></p>
<h2>Add a clip</h2><pre>curl -F file=@walk.bvh -F label=walk {base}/api/v1/documents
mcml import walk.bvh --label walk --server {base}</pre>
<h2>Find frames by motion name</h2><pre>curl -G {base}/api/v1/xpath \\
  --data-urlencode "q=//frame[motion_name='{html.escape(example)}']" -d as=runs</pre>
<h2>Library ({total:,})</h2>{more}
<table><thead><tr><th>Name</th><th>Project</th><th>Format</th><th class="n">Frames</th><th>Motion names</th>
<th>Get</th></tr></thead>
<tbody>{rows or '<tr><td colspan="6">Nothing is stored yet.</td></tr>'}</tbody></table>""",
    )


def page(title: str, body: str, *, status: int = 200, forms: bool = False) -> HTMLResponse:
    """A page in the plain style. forms: it may send forms to this server."""
    return HTMLResponse(
        f"""<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<meta name="viewport" content="width=device-width,initial-scale=1"><style>{_STYLE}</style></head><body><main>
{body}
</main></body></html>""",
        status,
        page_policy(styles=[_STYLE], forms=forms),
    )


def _row(stored: StoredDocument, names: list[str], markers: bool) -> str:
    address = f"/api/v1/documents/{stored.uuid}"
    exports = " ".join(
        f'<a href="{address}/export?format={name}" title="as {name}">{name}</a>' for name in _EXPORTS[markers]
    )
    labels = ", ".join(html.escape(name) for name in names[:8]) + (" …" if len(names) > 8 else "")
    return (
        f'<tr><td><a href="{address}">{html.escape(stored.name)}</a></td><td>{html.escape(stored.project)}</td>'
        f'<td>{html.escape(stored.format)}</td><td class="n">{stored.frames:,}</td><td>{labels}</td>'
        f'<td><a href="{address}/mcml">mcml</a> {exports}</td></tr>'
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
        f'<tr id="{slug(kind)}"><td>{html.escape(kind.__name__)}</td><td>{status}</td>'
        f"<td>{html.escape(kind.__doc__ or '')}</td></tr>"
        for kind, status in STATUS_OF.items()
    )
    return page("Problems", f"<h1>Problems</h1><table>{rows}</table>")


@router.get("/mcml.dtd")
def definition() -> FileResponse:
    """The definition of the language."""
    return FileResponse(dtd_path(), media_type="application/xml-dtd", filename="mcml.dtd")

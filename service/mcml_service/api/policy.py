"""Security headers of every answer: allowed sources and scripts, no type sniffing, and allowed frames."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence

NOTHING = "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
FORMS = NOTHING.replace("form-action 'none'", "form-action 'self'")

DEFAULTS = (
    ("content-security-policy", NOTHING),
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
)
"""Default headers of every answer."""

ONLY_TLS = ("strict-transport-security", "max-age=31536000")
"""Header of every answer to a request over https, to the server or to a trusted proxy.

It does not cover subdomains, which may belong to others.
"""


def page_policy(
    styles: Sequence[str] = (), scripts: Sequence[str] = (), more: str = "", *, forms: bool = False
) -> dict[str, str]:
    """Return the header of a page that may use only these inline texts, identified by their hashes.

    styles, scripts: the exact text between the tags. more: further directives. forms: whether it submits forms to this
    server.
    """
    own = [("style-src", styles), ("script-src", scripts)]
    listed = "; ".join(f"{name} {' '.join(map(_source, texts))}" for name, texts in own if texts)
    return {"content-security-policy": "; ".join(part for part in (FORMS if forms else NOTHING, listed, more) if part)}


def _source(text: str) -> str:
    """A text's hash; or a source that is written as in the policy, such as 'self'."""
    if text.startswith("'"):
        return text
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"

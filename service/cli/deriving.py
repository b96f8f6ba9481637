"""`mcml db derive`: bodies of documents for questions about motion."""

from __future__ import annotations

import sys
import time

from service.cli.bar import Bar
from service.cli.shared import DatabaseOption, JsonOption, chosen_settings, console, open_database, print_json
from service.clips.derive import derive_missing


def derive(database: DatabaseOption = None, as_json: JsonOption = False) -> None:
    """Work out the bodies of documents that have none yet, so that questions about motion find them. It may be stopped
    and begun again at any time."""
    store = open_database(chosen_settings(database))
    started = time.monotonic()
    with Bar("deriving", "documents", disable=as_json or not sys.stderr.isatty()) as bar:
        done = derive_missing(store, lambda done, of: bar.tell(done, of, "deriving"))
    if as_json:
        print_json({"derived": done})
    elif done:
        console.print(f"derived the bodies of {done:,} documents in {time.monotonic() - started:.1f} s")
    else:
        console.print("every document has its body, nothing to do")

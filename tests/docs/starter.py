"""Starts `mcml` by forking a process that has imported it: each example of the docs would import it again otherwise.

`python -m tests.docs.starter SOCKET` waits there. CLIENT is a script that stands in the place of `mcml`: it hands
over its arguments, folder, environment and open files, and ends as the command ends.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import sys

CLIENT = """#!{python} -IS
import json, os, socket, sys
wire = socket.socket(socket.AF_UNIX)
wire.connect({path!r})
words = json.dumps([sys.argv[1:], os.getcwd(), dict(os.environ)]).encode()
socket.send_fds(wire, [len(words).to_bytes(8, "big")], [0, 1, 2])
wire.sendall(words)
code = wire.recv(1)
sys.exit(code[0] if code else 70)
"""


def serve(path: str) -> None:
    """Run commands until this process is ended."""
    import mcml_service.cli
    import mcml_service.cli.commands
    import mcml_service.operations.analyses
    import mcml_service.xpath.queries  # noqa: F401  # what most commands need

    listener = socket.socket(socket.AF_UNIX)
    listener.bind(path)
    listener.listen(64)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    print("ready", flush=True)
    while True:
        wire, _ = listener.accept()
        if os.fork() == 0:
            listener.close()
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            os._exit(_run(wire))
        wire.close()


def _run(wire: socket.socket) -> int:
    size, files, _, _ = socket.recv_fds(wire, 8, 3)
    words = b""
    while len(words) < int.from_bytes(size, "big"):
        words += wire.recv(1 << 16)
    arguments, folder, environment = json.loads(words)
    for target, file in enumerate(files):
        os.dup2(file, target)
        os.close(file)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv = ["mcml", *arguments]
    from mcml_service.cli import main

    code = 0
    try:
        main()
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    except BaseException:
        import traceback

        traceback.print_exc()
        code = 70
    sys.stdout.flush()
    sys.stderr.flush()
    wire.sendall(bytes([code & 255]))
    return code & 255


if __name__ == "__main__":
    serve(sys.argv[1])

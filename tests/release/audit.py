"""Known faults of the packages that `requirements-dev.lock` names: `python -m tests.release.audit [--required]`.

Asks the database of Open Source Vulnerabilities, by pip-audit. Where it cannot be reached the check is skipped in one
line; --required: that is a failure.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

LOCK = Path(__file__).resolve().parents[2] / "requirements-dev.lock"
NO_NETWORK = ("ConnectionError", "ConnectTimeout", "ReadTimeout", "ServiceError")


def audit(lock: Path = LOCK, *, required: bool = False, more: tuple[str, ...] = ()) -> int:
    """Print what is known. Returns what the program ends with: 0 where nothing is. more: options of pip-audit."""
    asked = [sys.executable, "-m", "pip_audit", "--requirement", str(lock), "--disable-pip", "--require-hashes"]
    told = ["--vulnerability-service", "osv", "--format", "json", "--progress-spinner", "off"]
    done = subprocess.run([*asked, *told, *more], capture_output=True, text=True, check=False)
    if not done.stdout.strip():
        last = (done.stderr.strip().splitlines() or ["pip-audit said nothing"])[-1]
        if any(name in done.stderr for name in NO_NETWORK) and not required:
            print("audit of packages skipped: no network")
            return 0
        print(f"audit of packages failed: {last}")
        return 1
    packages = json.loads(done.stdout)["dependencies"]
    faults = [(package, fault) for package in packages for fault in package.get("vulns", ())]
    for package, fault in faults:
        mended = ", ".join(fault["fix_versions"]) or "no version yet"
        print(f"{package['name']} {package['version']}: {fault['id']}, mended in {mended}")
    print(f"audit of packages: {len(packages)} asked, {len(faults)} known faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(audit(required="--required" in sys.argv[1:]))

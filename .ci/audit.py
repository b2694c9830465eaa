"""Look for known vulnerabilities in an installed environment: ``audit.py PIP_AUDIT SITE_PACKAGES``.

PIP_AUDIT is the program pip-audit. Advisories come over the network: where none can be had this states
"not checked" and passes. What is found, and not accepted below with a reason, fails.
"""

import json
import subprocess
import sys
from typing import Any

# Identifier of an advisory: why it does not concern this project.
ACCEPTED: dict[str, str] = {}
SERVICES = ("pypi", "osv")
SECONDS = 300.0


def read_report(text: str) -> list[dict[str, Any]]:
    """Return the packages about which advisories were looked up; none if the service told nothing."""
    try:
        packages = json.loads(text)["dependencies"]
    except (ValueError, KeyError, TypeError):
        return []
    return [package for package in packages if "vulns" in package]


def judge(packages: list[dict[str, Any]], accepted: dict[str, str]) -> tuple[list[str], bool]:
    """Return a line for each advisory and a last one, and whether all advisories are accepted."""
    lines, good = [], True
    for package in packages:
        for advisory in package["vulns"]:
            names = [advisory["id"], *advisory.get("aliases", [])]
            reason = next((accepted[name] for name in names if name in accepted), None)
            fixed = ", ".join(advisory.get("fix_versions", [])) or "no release yet"
            about = f"{package['name']} {package['version']}: {' '.join(names)}, fixed in {fixed}"
            lines.append(f"{about}; accepted: {reason}" if reason else about)
            good = good and reason is not None
    if not packages:
        lines.append(
            "Known vulnerabilities: not checked, for no advisory service could be reached."
        )
    elif not lines:
        lines.append(f"Known vulnerabilities: none in {len(packages)} packages.")
    return lines, good


def main(program: str, folder: str) -> int:
    """Print what is known; return 1 if something is not accepted."""
    packages: list[dict[str, Any]] = []
    for service in SERVICES:
        command = [program, "--path", folder, "--skip-editable", "-f", "json", "-s", service]
        try:
            told = subprocess.run(
                [*command, "--progress-spinner", "off", "--timeout", "10"],
                capture_output=True,
                text=True,
                timeout=SECONDS,
                check=False,
            )
        except (OSError, subprocess.TimeoutExpired):
            continue
        if packages := read_report(told.stdout):
            break
    lines, good = judge(packages, ACCEPTED)
    print("\n".join(lines))
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

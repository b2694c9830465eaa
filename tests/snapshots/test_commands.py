"""Printed text of each command, as it was last looked at."""

REFUSED = {f"refused-{d}" for d in ("engines", "chains", "studies", "texts", "commands", "calls")}
OTHER = {"stored-run", "report", "report-of-all", "concluded", "warned-engines", *REFUSED}

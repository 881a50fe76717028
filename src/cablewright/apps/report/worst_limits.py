"""The worst position of every limit, violations first, in plain words."""

from __future__ import annotations

import math

from cablewright.analyses.feasibility import Finding
from cablewright.apps.quantities import allowed_range, count, duration, quantity
from cablewright.apps.report.check_summary import Digest
from cablewright.apps.report.page import Html, element, join, short_name, table


def ranked(findings: tuple[Finding, ...]) -> list[Finding]:
    """Return violations first; among equals that first whose margin is smallest for the size of its limit."""
    return sorted(findings, key=lambda finding: (finding.violations == 0, _room(finding)))


def findings_table(digest: Digest) -> Html:
    """Return the HTML table of findings, one row each."""
    found = ranked(digest.check.findings)
    if not found:
        return element("p", "No limit is known for this robot: nothing was judged.")
    head = ("limit", "line", "margin", "worst value", "allowed", "where", "samples outside")
    return table(head, (_row(digest, finding) for finding in found), numbers=(2, 3, 6))


def _room(finding: Finding) -> float:
    """Return the margin as a share of the limit; below everything where there is no solution at all."""
    if not finding.unit or math.isnan(finding.margin):
        return -math.inf
    low, high = finding.allowed
    ends = [abs(end) for end in (low, high) if math.isfinite(end)]
    return finding.margin / ((high - low if len(ends) == 2 else sum(ends)) or 1.0)


def _row(digest: Digest, finding: Finding) -> tuple[str, ...]:
    total = len(digest.check.samples)
    share = f" ({_percent(finding.violations / total)})" if finding.violations else ""
    outside = count(finding.violations) + share
    where = (_place(digest, finding), outside)
    if not finding.unit:  # no number to compare: the statics have no answer there
        words = element("span", "no solution", class_="mark no")
        return (join([words, element("small", finding.limit)]), _line(finding), "", "", "", *where)
    value, allowed = quantity(finding.value, finding.unit), allowed_range(*finding.allowed, finding.unit)
    return (_limit(finding), _line(finding), _margin(finding), value, allowed, *where)


def _limit(finding: Finding) -> Html:
    """Name the limit and explain its purpose."""
    mark = element("span", finding.limit, class_="mark no" if finding.violations else "mark")
    return join([mark, element("small", finding.why)]) if finding.why else mark


def _line(finding: Finding) -> str:
    return short_name("platform" if finding.line is None else finding.line)


def _margin(finding: Finding) -> Html:
    """Write the distance inside or outside in words: colour alone is not enough on paper."""
    size = quantity(abs(finding.margin), finding.unit)
    if finding.violations:
        return element("span", f"{size} outside", class_="mark no")
    return element("span", f"{size} left", class_="mark")


def _place(digest: Digest, finding: Finding) -> Html:
    samples, at = digest.check.samples, finding.sample
    x, y, z = (f"{v:.2f}".replace("-", "\N{MINUS SIGN}") for v in samples.positions[at])
    where = samples.where(at).removeprefix("in ")
    first = f"{where}, {digest.check.job.move_name} {count(int(samples.line[at]))}"
    return join(
        [
            element("span", first, class_="keep"),
            element("small", f"at ({x}, {y}, {z}) m, after {duration(float(digest.check.law.time[at]))}"),
        ]
    )


def _percent(share: float) -> str:
    return "less than 0.1 %" if share < 1e-3 else f"{share * 100:.3g} %"

"""How verdicts are shown, and the decision rules in words."""

from dataclasses import dataclass

from gyrotest.records.result import Verdict
from gyrotest.records.spec import DecisionRule


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """How a verdict is shown: it must also be told apart in grey."""

    symbol: str
    word: str
    short: str
    style: str
    colour: str


LOOKS = {
    Verdict.PASS: Look(symbol="✓", word="PASS", short="PASS", style="pass", colour="#14602f"),
    Verdict.CONDITIONAL_PASS: Look(
        symbol="(✓)", word="CONDITIONAL PASS", short="COND. PASS", style="conditional", colour="#7a5200"
    ),
    Verdict.CONDITIONAL_FAIL: Look(
        symbol="(✗)", word="CONDITIONAL FAIL", short="COND. FAIL", style="conditional", colour="#a04000"
    ),
    Verdict.FAIL: Look(symbol="✗", word="FAIL", short="FAIL", style="fail", colour="#a31515"),
    Verdict.INCOMPLETE: Look(
        symbol="⚠", word="INCOMPLETE", short="INCOMPLETE", style="incomplete", colour="#7a3e00"
    ),
}

RULE_WORDS = {
    DecisionRule.SIMPLE: "simple acceptance",
    DecisionRule.GUARDED: "guarded acceptance",
    DecisionRule.GUARDED_NONBINARY: "guarded acceptance with conditional verdicts",
}

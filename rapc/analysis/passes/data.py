"""RAP075 and RAP076: sensor data that no declaration knows, or that do not meet it.

Only tests name data: a row of a script sends them with a result, to the handlers of the
world that the test names.
"""

from __future__ import annotations

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.named import MISUSES, report_arguments, report_unknown
from rapc.base.diagnostics import Rule, Severity

UNDECLARED = Rule(
    code="RAP075",
    name="undeclared-datum",
    severity=Severity.ERROR,
    summary="a test sends a sensor datum that is not declared",
    why="""A row of a script may send sensor data with `:data`. What a world sends is
declared in the library that is to take it in; no handler is called for anything
else.""",
    example="""\
(declare-primitive look () (okay))
(declare-sensor-datum seen (?thing))
(define-rap (look-around) (method (primitive (look))))
(define-test sees-the-box
  (world truck)
  (script ((look) :data ((sene box))))
  (task (look-around)))
""",
    better="""\
(declare-primitive look () (okay))
(declare-sensor-datum seen (?thing))
(define-rap (look-around) (method (primitive (look))))
(define-test sees-the-box
  (world truck)
  (script ((look) :data ((seen box))))
  (task (look-around)))
""",
)

ARITY = Rule(
    code="RAP076",
    name="wrong-datum-arity",
    severity=Severity.ERROR,
    summary="a sensor datum has another number of arguments than was declared",
    why="""A world sends a datum with the arguments it was declared with, and its
handler takes those and no others.""",
    example="""\
(declare-primitive look () (okay))
(declare-sensor-datum seen (?thing))
(define-rap (look-around) (method (primitive (look))))
(define-test sees-the-box
  (world truck)
  (script ((look) :data ((seen box here))))
  (task (look-around)))
""",
    better="""\
(declare-primitive look () (okay))
(declare-sensor-datum seen (?thing))
(define-rap (look-around) (method (primitive (look))))
(define-test sees-the-box
  (world truck)
  (script ((look) :data ((seen box))))
  (task (look-around)))
""",
)


def _run(run: Pass) -> None:
    report_unknown(run, UNDECLARED, ("datum",))
    report_arguments(run, ARITY, ("datum",))


ANALYZER = Analyzer(
    name="data",
    doc="Finds sensor data in tests that are not declared, or declared otherwise.",
    run=_run,
    needs=(MISUSES,),
    rules=(UNDECLARED, ARITY),
)

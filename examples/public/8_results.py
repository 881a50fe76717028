"""Results and errors.

What all results share, and the one family of exceptions.
"""

import cablewright as cw

hold = cw.inverse(cw.load("house-printer"), [1.0, 2.0, 1.5])
assert isinstance(hold, cw.Result)
assert hold.status is cw.Status.OK
figures: tuple[cw.Figure, ...] = hold.figures
problem: cw.Problem = cw.problems("tensions")[0]
assert problem.error(problem.solve()[0]) <= problem.tolerance
turned: cw.View = cw.view(hold)  # in a notebook; turned.save("FILE.html") elsewhere
try:
    cw.inverse(cw.load("house-printer"), [1.0, 2.0, 1.5], cable="catenery")
except cw.UnknownName as reason:
    print(isinstance(reason, cw.InputError), reason)
family = (cw.AnswerError, cw.CablewrightError, cw.EnvironmentFault)

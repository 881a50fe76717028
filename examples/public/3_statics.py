"""Statics.

One pose or a batch, by the shape of the input. A result contains its robot, its status and its margins, and becomes
JSON by `to_dict()`.
"""

import cablewright as cw

robot, model = cw.load("house-printer"), cw.Model(cw.load("merlet2023"))
hold: cw.Equilibrium = cw.inverse(robot, [1.0, 2.0, 1.5])
back = cw.forward(robot, hold.lengths)
move: cw.Linearisation = cw.linearise(back)
proof: cw.Certificate = cw.certify(back)
assert proof.certified

slack_line = cw.inverse(model, [0.0, -1.0, 1.0])
every: cw.Equilibria = cw.equilibria(model, slack_line.lengths)
box: cw.PoseBox = cw.enclose_poses(cw.forward(model, slack_line.lengths), 1e-3)
tracker = cw.Tracker(model, slack_line.lengths, cw.TrackerSettings())
longer = cw.let_out(model, slack_line.lengths, "north-west", [0.0, 0.01, 0.02])
excess = cw.excess_lengths(longer)
sets: tuple[cw.SlackSet, ...] = cw.slack_sets(model, [0.0, -1.0, 1.0])
held = cw.solve_with_slack(
    model, [0.0, -1.0, 1.0], {sets[0].slack[0]: 0.5 * (sets[0].excess_low + sets[0].excess_high)}
)

beam = cw.load("jung2020")
tensions: cw.Distribution = cw.tension_distribution(beam, [0.2, 0.1, 0.9], cable="rigid")
margin: cw.Capacity = cw.capacity(beam, [0.2, 0.1, 0.9], cable="rigid")
closed = cw.wrench_closure(beam, [0.2, 0.1, 0.9], cable="rigid")
own_objective = cw.Quadratic

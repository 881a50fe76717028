"""Jung 2020 beside cablewright: volumes, slices, the retraction law, frequencies along the boundary, widened ends.

Volumes are counted on 41^3 nodes as his seem to be, and converged. His Table 3 prints exit points 0.106 m apart where
its caption says 0.10 m: the caption is taken here.
"""

import numpy as np

import cablewright as cw

RIGID = cw.Fidelity.of("rigid")
LENGTHS = (2.0, 1.6, 1.2)  # m
TIP = 0.2  # m: how far the lower platform points are below the place that he calls both tip and centre of mass


def beam(apart: float, width: float = 0.04) -> cw.Robot:
    """jung2020 with its neighbouring exit points *apart* (m) and its top and bottom widened to *width* (m) in all."""
    widths = cw.Change("width-top-x+width-bottom-y")
    return cw.changed(cw.load("jung2020"), {cw.Change("exit-distance"): apart, widths: width})


TABLE_1, TABLE_3 = cw.load("jung2020-table1"), beam(0.1)


def volumes() -> None:
    """Volumes by the distance of neighbouring exit points and by criterion."""
    print("closed form, m^3           paper   counted   of frame   converged")
    rows = (
        ("Table 1", "2.96", TABLE_1),
        ("Table 2, 0.0283 m", "-", beam(0.0283)),
        ("Table 3, 0.1 m", "-", TABLE_3),
        ("Table 2, 0.212 m", "-", beam(0.2121)),
    )
    for name, paper, robot in rows:
        model = cw.Model(robot, RIGID)
        counted, volume = cw.count_nodes(model, "closed-form"), cw.workspace(model, "closed-form")
        share = 100.0 * counted.fraction
        print(f"{name:<24} {paper:>7} {counted.volume:>9.3f} {share:>8.1f} % {volume.volume:>11.2f}")
    print("\nTable 3 by length, counted  closed form  improved   exact   exact gains   exact, converged")
    model = cw.Model(TABLE_3, RIGID)
    for length in LENGTHS:
        closed, improved, exact = (
            cw.count_nodes(model, criterion, retraction=length).volume
            for criterion in ("closed-form", "improved-closed-form", "exact")
        )
        reach = cw.workspace(model, "exact", retraction=length).volume
        gain = 100.0 * (exact / closed - 1.0)
        print(f"{length:.1f} m {closed:>33.3f} {improved:>9.3f} {exact:>7.3f} {gain:>10.0f} % {reach:>16.2f}")


def slices() -> None:
    """The largest slice as a share of the frame's floor: 0.64 in his Fig. 10."""
    model = cw.Model(TABLE_3, RIGID)
    counted = cw.count_nodes(model, "closed-form", retraction=1.2).slices().max() / 4.0
    whole = cw.workspace(model, "closed-form", retraction=1.2).slices(np.linspace(0.0, 2.0, 401)).max() / 4.0
    print(f"\nlargest slice: paper 0.64, counted {counted:.3f}, converged {whole:.3f}")


def law() -> None:
    """Retraction laws, closed form, between 1.2 and 2 m."""
    model = cw.Model(TABLE_3, RIGID)
    own = cw.retraction(model, "closed-form", point="origin").law
    print("\nretraction law, m          counted   converged")
    rows = (
        ("always 2 m", cw.RetractionLaw(0.0, 2.0, 1.2, 2.0, "origin")),
        ("his, z of p", cw.RetractionLaw(-0.675, 1.929, 1.2, 2.0, "origin")),
        ("his, z of the lower end", cw.RetractionLaw(-0.675, 1.929 + 0.675 * TIP, 1.2, 2.0, "origin")),
        (f"own, {own.slope:.3f} z + {own.intercept:.3f}", own),
    )
    for name, each in rows:
        counted = cw.count_nodes(model, "closed-form", retraction=each, point="origin").volume
        whole = cw.workspace(model, "closed-form", retraction=each, point="origin").volume
        print(f"{name:<24} {counted:>9.3f} {whole:>11.3f}")
    counted, whole = best_of_slices(model)
    print(f"{'each slice at its best':<24} {counted:>9.3f} {whole:>11.3f}")


def best_of_slices(model: cw.Model) -> tuple[float, float]:
    """Volume of each slice at its own best length: counted (lengths in steps of 0.05 m), and converged."""
    layers = [cw.count_nodes(model, "closed-form", retraction=length).slices() for length in np.linspace(1.2, 2.0, 17)]
    counted = float(np.max(layers, axis=0).sum()) * 2.0 / 41
    return counted, cw.retraction(model, "closed-form").best_volume


def frequencies() -> None:
    """Lowest frequencies on the counted boundary (steps of 0.1 m) of the three lengths, and what widening costs."""
    print("\nends' width   paper    elastic alone       with the geometric part   mostly   along z   frame lost")
    rows = ((0.04, "1.2 Hz"), (0.08, "7 to 17"), (0.16, "8 to 21"))
    first = cw.count_nodes(cw.Model(TABLE_3, RIGID), "closed-form").fraction
    for width, paper in rows:
        elastic, whole, named = [], [], []
        for length in LENGTHS:
            robot = cw.with_box_inertia(beam(0.1, width).retracted(length))
            found = cw.boundary_modes(cw.Model(robot, cw.Fidelity.of("elastic")), "closed-form")
            plain = cw.modes(found.modes.equilibrium, geometric=False)
            elastic += plain.lowest.tolist()
            whole += found.lowest.tolist()
            named += plain.dominant[:, 0].tolist()
        lost = 100.0 * (first - cw.count_nodes(cw.Model(beam(0.1, width), RIGID), "closed-form").fraction)
        most = cw.FREEDOMS[np.bincount(named).argmax()]
        along_z = f"{named.count(2)} of {len(named)}"
        print(
            f"{width:.2f} m {paper:>14} {min(elastic):>8.2f} to {max(elastic):.2f} Hz "
            f"{min(whole):>13.1f} to {max(whole):.1f} Hz {most:>8} {along_z:>13} {lost:>6.1f} points"
        )


def main() -> None:
    """Print all tables."""
    volumes()
    slices()
    law()
    frequencies()


if __name__ == "__main__":
    main()

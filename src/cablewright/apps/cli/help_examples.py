"""Further examples of each command, for its help and the page of commands. Tests parse them."""

from __future__ import annotations

from typing import Final

FURTHER: Final[dict[str, tuple[str, str]]] = {
    "show": ("show house-printer examples/house.toml", "show cogiro --at 0,0,2 --png cogiro.png"),
    "inverse": (
        "inverse house-printer --at 1,2,1.5 --json",
        "inverse jung2020 --at 0.3,0.2,0.4,0.1,0,0 --retraction 1.4",
    ),
    "forward": (
        "forward house-printer --lengths 33.482453,32.654070,30.870149,31.785348",
        "forward merlet2023 --lengths runs/check-merlet2023-job/lengths.csv",
    ),
    "equilibria": (
        "equilibria house-printer --lengths 33.5,32.7,30.9,31.8 --starts 50",
        "equilibria merlet2023 --lengths 10.1187,9.3676,10.9961,11.3476 --exhaustive",
    ),
    "accuracy": (
        "accuracy house-printer --plane 1 --half-width 3 --step 0.5",
        "accuracy house-printer --path examples/helix.toml --method monte-carlo",
    ),
    "workspace": (
        "workspace cogiro --tolerance 0.02 --mesh workspace.stl",
        "workspace jung2020 --criterion exact --plot workspace.pdf --plot-width one-column",
    ),
    "retraction": ("retraction jung2020 --plot law.png", "retraction jung2020 --from 0.8 --to 1.4 --steps 7"),
    "modes": ("modes jung2020 --boundary --plot modes.png", "modes merlet2023 --at 0,0,1 --log swing.mcap"),
    "vibration": (
        "vibration merlet2023 --at 0,0,1 --line north-west --record shaken.csv",
        "vibration house-printer --at 1,2,1.5 --line north-west --frequency 4 --in-plane 4.2 --sigma 0.01",
    ),
    "trade": (
        "trade jung2020 --vary exit-distance=0.2:0.4:3 --plot trade.png",
        "trade jung2020 --vary width-x=1,1.2 --vary mass=20,40 --workers 4",
    ),
    "design": (
        "design house-printer examples/helix.toml --vary exit_point.z=8:15 --objective lowest_frequency",
        "design house-printer examples/helix.toml --vary tension-min=20:200 --objective expected_error --workers 4",
    ),
    "interference": (
        "interference house-printer examples/helix.toml --clearance 0.05",
        "interference house-printer examples/helix.toml --report lines.html",
    ),
    "bracket": (
        "bracket house-printer --job examples/helix.toml",
        "bracket house-printer --at=-2.25,-6.75,13 --times 2 --vtu stress.vtu",
    ),
    "survey": (
        "survey survey.gsi --plan survey.toml --robot mine.toml --out surveyed.toml",
        "survey markers.csv --report survey.html",
    ),
    "tags": ("tags --out sheet.pdf", "tags tags.toml --paper A3 --out tags.svg"),
    "camera": ("camera pictures/ --out phone.toml", "camera pictures/ --tags sheet.toml --json"),
    "poses": ("poses mine.toml --count 20 --out poses.csv", "poses mine.toml --criterion worst-sigma --sigma 1e-3"),
    "calibrate": ("calibrate mine.toml data.csv --out calibrated.toml", "calibrate calibrated.toml later.csv --check"),
    "simulate-calibration": (
        "simulate-calibration mine.toml --poses 20 --noise 1e-3 --out data.csv",
        "simulate-calibration mine.toml --poses 20 --noise 1e-3 --tension-noise 5 --truth truth.json --out data.csv",
    ),
    "modulus": (
        "modulus test.csv --initial-length '2 m' --diameter '4 mm' --breaking-load '10.29 kN'",
        "modulus test.csv --initial-length '2 m' --robot mine.toml --plot modulus.png",
    ),
    "creep": (
        "creep test.csv --initial-length '2 m' --retardations '30 s,10 min,2 h'",
        "creep test.csv --initial-length '2 m' --plot creep.png",
    ),
    "walls": ("walls scan.csv --unit mm --angle-unit deg", "walls scan.csv --mask 170:190 --report walls.html"),
    "check": (
        "check mine.toml part.gcode --bead 1.2mm,0.6mm",
        "check mine.toml job.toml --clearance 0.05 --out runs/first",
    ),
    "fit": ("fit mine.toml part.stl", "fit mine.toml part.gcode --max-error '5 mm' --plot fit.png"),
    "stages": (
        "stages examples/rails.toml examples/wall.toml --exit-heights 2.5,3.5,4.5 --out staged.toml",
        "stages mine.toml tall.toml --exit-heights 3,4,5,6 --layers 20 --plot stages.png",
    ),
    "print": (
        "print mine.toml part.gcode --machine machine.toml",
        "print merlet2023 examples/blind-machines.toml --resume --out runs/example",
    ),
    "campaign": (
        "campaign mine.toml part.gcode --machine machine.toml --machines 20",
        "campaign mine.toml part.gcode --machine machine.toml --machines 100 --workers 4 --report campaign.html",
    ),
    "simulate": (
        "simulate merlet2023 --hold 0,0,1.2 --duration 10 --out rest.mcap",
        "simulate merlet2023 --loop 28 --fault north,5,8 --out loop.mcap",
    ),
    "drives": (
        "drives jog mine.toml --machine drives.toml --line north --speed 0.02",
        "drives home mine.toml --machine drives.toml --place 0,0,1",
    ),
    "serve": ("serve mine.toml --machine machine.toml", "serve mine.toml --machine drives.toml --try"),
    "replay": (
        "replay runs/print-merlet2023-job --report replay.html",
        "replay log.mcap --estimator filter --plot replay.png",
    ),
    "robots": ("robots", "robots mine.toml --support"),
    "new": ("new wall --layout planar --size 3,2", "new tower --size 4,4,6 --mass 25 --cable steel-4mm"),
    "import": ("import config.g --out hangprinter.toml", "import printer.cfg --cable dyneema-2mm --out plotter.toml"),
    "export": (
        "export klipper mine.toml part.gcode --out firmware",
        "export wirex house-printer --out house.wcrfx",
    ),
    "machines": ("machines", "machines --for mine.toml"),
    "schema": ("schema robot", "schema machine"),
    "warm": ("warm", "warm --json"),
    "curves": ("curves --length 28 --area 3,3 --plot curves.png", "curves --count 30 --min-radius 0.3"),
}

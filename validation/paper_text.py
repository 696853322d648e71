"""The text of validation/paper.md from the results of validation/paper.py and validation/m427.py."""

import re
import textwrap

import paper_plots
from paper_plots import NAMES

PAPER_TABLE_2 = {
    "translation, 0.1 chord": 212,
    "translation, 0.2 chord": 289,
    "rotation, 20 degrees": 193,
    "rotation, 40 degrees": 259,
}
PAPER_TABLE_4 = [
    ["Algorithm 1", "7.5e-05 m", "495", "5,261", ""],
    ["Algorithm 1", "its own", "592", "9,637", ""],
    ["Algorithm 2", "its own", "1,003", "512", "1,786"],
]
BLADE_RADIUS = 6  # chords


def page(results, earlier=""):
    """The page; parts that have not been run are as on an earlier page."""
    parts = [HEAD]
    for name, part, heading in (
        ("table2", table2, "## One step"), ("table3", table3, "## Cyclic pitch"), ("greedy", greedy, "## An independent"),
        ("table4", table4, "## The M427 blade (table 4, figures"), ("cost", cost, "### Cost"),
    ):  # fmt: skip
        parts.append(part(results) if name in results else section(earlier, heading))
    whole = [results[name] for name in ("m427_none", "m427_summary") if name in results]
    parts.append(m427(whole) if whole else section(earlier, "## The M427 blade at the paper's size"))
    paragraphs = "\n\n".join(part.strip() for part in parts).split("\n\n")
    return "\n\n".join(filled(paragraph.strip("\n")) for paragraph in paragraphs if paragraph.strip()) + "\n"


def section(text, heading):
    """The section of a page whose heading begins so, if there is one."""
    sections = re.split(r"^(?=##)", text, flags=re.M)
    return next((one for one in sections if one.startswith(heading)), "")


def filled(paragraph):
    """Prose in lines of one length; tables, headings, pictures and what is indented as they are."""
    if paragraph.startswith(("|", "#", "!", "    ")):
        return paragraph
    return textwrap.fill(" ".join(paragraph.split()), width=125, break_long_words=False, break_on_hyphens=False)


HEAD = """
# The paper's cases

The tables and figures of C. Sheng and C. B. Allen, "Efficient Mesh Deformation Using Radial Basis Functions on Unstructured
Meshes", AIAA Journal 51(3), 2013, on similar meshes. The paper's meshes are not public. These are made by `azimesh sample blade`, with
the same number of nodes where that is said, all hexahedra, the first cell 1e-5 chord high, inside a cylinder that stays fixed. So
compare sizes and trends, not last digits. Wendland C2 with a support radius of one blade radius throughout, on
two shared cores of an AMD EPYC with AVX2; the paper had 16 processors. Algorithm 1 is `selection.method = "real"`, Algorithm 2 is
`"constant"` with the largest displacement of the motion in x, y and z as its vector, and `"sequence"` is azimesh's own method.

These commands make all of it again; the first and the last write this page:

    .venv/bin/python validation/paper.py
    .venv/bin/python validation/paper_greedy.py
    .venv/bin/python validation/m427.py --tolerance 7.5e-5 --quality none
    .venv/bin/python validation/m427.py --tolerance 7.5e-5 --quality summary --steps 120
    .venv/bin/python validation/paper.py --draw

"Error" is the largest distance of a surface node from where the motion puts it **before** the
correction (`selection_error` of steps.csv), over all surface nodes and not only the base points; after the correction
surfaces are exact to the last bit. "Inverted" counts cells at all steps together.
"""


def table(header, rows):
    """A Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def size(made):
    """How large a sample is, in words."""
    cells = sum(made["cells"].values()) - sum(made["tags"].values())
    return f"{made['nodes']:,} nodes, {made['surface_nodes']:,} of them on boundaries, {cells:,} cells"


def span(values):
    """The one value, or the least and the most."""
    least, most = min(values), max(values)
    return f"{least:,.0f}" if least == most else f"{least:,.0f}-{most:,.0f}"


def seconds(value):
    """Seconds with as many digits as mean something."""
    digits = next((digits for least, digits in ((10, 1), (0.1, 2), (0.01, 3)) if value >= least), 4)
    return f"{value:.{digits}f}"


def inverted(run):
    """Inverted cells at all steps."""
    return round(sum(run["inverted"]))


CHOSEN = [
    "base points", "Algorithm 1", "Algorithm 2", "sequence", "paper, Algorithm 1", "Algorithm 1, support 2 to 60 chords",
    "Algorithm 1, 5e-4 blade radii",
]  # fmt: skip
KEPT = ["", "error, Algorithm 2", "inverted, all three", "min scaled Jacobian", "mean scaled Jacobian", "first cell"]


def table2(results):
    """One step of rigid motion."""
    result = results["table2"]
    runs, before = result["runs"], result["before"]
    tolerance = runs["rotation, 20 degrees"]["real"]["tolerance"]
    minimum, mean = before["min_scaled_jacobian"], before["mean_scaled_jacobian"]
    selection = [run["seconds"]["selection"] for methods in runs.values() for run in methods.values()]
    took = f"Choosing took {seconds(min(selection))} to {seconds(max(selection))} s."
    return f"""
## One step (table 2, figures 6 and 8)

An untwisted blade of NACA 0012 sections, chord 1, span 5, in a cylinder five chords in diameter, as in the paper:
{size(result["mesh"])} (the paper: 379,170 and 25,121). One step from the reference mesh; translations along the shaft, rotations about the
quarter chord; tolerance {tolerance:g} chord, that is {tolerance / (10 * BLADE_RADIUS):.1e} of ten blade radii. The paper gives
its translations in chords and in radii of the cylinder.

{table(CHOSEN, [chosen(name, result) for name in runs])}

The paper has 290 points for Algorithm 2. With one step, `sequence` has the same target as Algorithm 1 and chooses the same
points; with a translation so does Algorithm 2. {"" if is_busy(runs) else took}

The translations agree with the paper's, in number and in growth. Its rotations take fewer points than its
translations; here they take more, and [an independent greedy](#an-independent-greedy) agrees with that. From 4 chords on the support radius hardly
matters (second column from the right). It is not clear which length the paper's tolerance is relative to: at 5e-4 of the blade's radius,
3e-3 chord, the rotations come near the paper's numbers and the translations fall below them (last column).

Quality of the mesh as written, Algorithm 1 then Algorithm 2; `sequence` gives the meshes of Algorithm 1. The reference mesh has
a least scaled Jacobian of {minimum:.3f} and a mean of {mean:.3f}; "first cell" is the smallest ratio of a first-cell height at the
blade to that in the reference mesh. Algorithm 2 meets the tolerance for its constant vector; what error this leaves in the
motion itself is in the first column.

{table(KEPT, [kept(name, methods) for name, methods in runs.items()])}

![residual against base points](pictures/paper_residuals.png)

Lines: the error of each base point when it was chosen, the largest among the candidates of its round. Dots: the largest error
over all surface nodes at each sweep. The tolerance is the horizontal line. The selection ends only when a sweep over all nodes
has found it met.
"""


def chosen(name, result):
    """The row of a motion: how many base points each method takes."""
    base = [f"{result['runs'][name][method]['base_points'][0]:,.0f}" for method in NAMES]
    supports = span(result["by_support_radius"][name].values())
    return [name, *base, PAPER_TABLE_2.get(name, ""), supports, result["in_blade_radii"][name]]


def kept(name, methods):
    """The row of a motion: what becomes of the mesh."""
    row = [name, f"{methods['constant']['error'][0]:.1e}", sum(inverted(methods[method]) for method in NAMES)]
    for column, digits in (("min_jacobian", 3), ("mean_jacobian", 3), ("first_cell", 4)):
        real, constant = methods["real"][column][0], methods["constant"][column][0]
        row.append(f"{real:.{digits}f}, {constant:.{digits}f}")
    return row


def revolution_rows(runs, per):
    """A row a run: base points, errors, timings."""
    rows = []
    for tolerance, methods in runs.items():
        for method, run in methods.items():
            n_steps = len(run["azimuth"])
            over = sum(error > float(tolerance) for error in run["error"])
            rows.append([
                NAMES[method], f"{float(tolerance):g}" + per(float(tolerance)), span(run["base_points"]),
                f"{max(run['error']):.2e}", f"{over} of {n_steps}", inverted(run), f"{min(run['min_jacobian']):.3f}",
                *timings(run, n_steps),
            ])  # fmt: skip
    return rows


def timings(run, n_steps):
    """Seconds of the stages; nothing of a run on a busy machine."""
    if run["busy"]:
        return [""] * 5
    t = run["seconds"]
    each = [t["selection"], t["modes"], t["steps"] / n_steps, t["writing"] / n_steps, t["total"]]
    return [seconds(value) for value in each]


def is_busy(runs):
    """Whether any of the runs {...: {method: run}} was on a busy machine."""
    return any(run["busy"] for methods in runs.values() for run in methods.values())


def on_busy(runs):
    """What is said of seconds that were left out."""
    return "Seconds are left out where other work kept the machine busy during the run." if is_busy(runs) else ""


def unjudged(result):
    """What a step takes without quality, in a sentence."""
    text = f"Without the quality summary a step takes {seconds(result['unjudged_step'])} s, beside its writing."
    return "" if is_busy(result["runs"]) else text


REVOLUTION = [
    "method", "tolerance", "base points", "largest error", "steps over", "inverted", "min SJ", "selection, s",
    "modes, s", "step, s", "write, s", "total, s",
]  # fmt: skip

READING = """
Algorithm 1 chooses at every one of the 36 steps (`refresh` left out), the others once; "selection" and "modes" (the evaluation
of the chosen points at all nodes, with the correction) are sums over the run. "Step" is the positions and the quality summary of
one step, "write" one file, which overlaps with the next step; "total" is the whole run without reading the mesh and
without waiting for the disk. "Steps over" counts azimuths at which the error exceeds the tolerance.
"""


def table3(results):
    """Cyclic pitch over a revolution."""
    result = results["table3"]
    return f"""
## Cyclic pitch over a revolution (table 3, figure 11)

The same mesh, {size(result["mesh"])}.
Pitch 10.04 - 7.65 sin(psi) - 0.96 cos(psi) degrees, every 10 degrees of azimuth, each step from the reference mesh. Tolerances in chords. SJ is the scaled Jacobian, in the reference mesh at least
{result["before"]["min_scaled_jacobian"]:.3f}.

{table(REVOLUTION, revolution_rows(result["runs"], lambda _: ""))}

The paper, over its tolerances:

{table(["", "base points", "selection, s", "revolution, s"], [["Algorithm 1", "278-533", "778-2,297", ""], ["Algorithm 2", "283-652", "2.2-7.8", ""], ["both", "", "", "209-324"]])}
{READING} {on_busy(result["runs"])}

{unjudged(result)}

![base points and error against azimuth](pictures/paper_pitch.png)

{verdict(result["runs"])}
"""


def greedy(results):
    """The paper's algorithms in numpy, beside azimesh's."""
    found, one_step, revolution = results["greedy"], results["table2"]["runs"], results["table3"]["runs"]
    rows = []
    for name, numpy in found["one_step"].items():
        ours = one_step[name]
        rows.append(greedy_row(name, ours["real"]["tolerance"], ours, numpy, max(numpy["real"])))
    for name, numpy in found["revolution"].items():
        rows.append(greedy_row("cyclic pitch", float(name), revolution[name], numpy, numpy["real"]))
    times = [numpy["constant_error"] / float(name) for name, numpy in found["revolution"].items()]
    points = [numpy["constant"] for numpy in found["revolution"].values()]
    header = [
        "motion", "tolerance", "Algorithm 1", "in numpy", "Algorithm 2", "in numpy", "error of Algorithm 2 / tolerance", "in numpy",
    ]  # fmt: skip
    return f"""
## An independent greedy

`validation/paper_greedy.py` is the paper's greedy in plain numpy, without any code of azimesh: one point for each sweep over all
{found["surface_points"]:,} surface points. Base points, for cyclic pitch with Algorithm 1 at its hardest azimuth:

{table(header, rows)}

It finds the same as azimesh. Algorithm 1 takes more points for these rotations than the paper has, and Algorithm 2 meets its tolerance for the
constant vector, but leaves {min(times):.0f} to {max(times):.0f} times the tolerance in the cyclic pitch, where the paper calls its error comparable to that of
Algorithm 1. In the number of points, {min(points)} to {max(points)}, Algorithm 2 agrees with the paper's 283 to 652. azimesh takes a few per cent more points:
it chooses in rounds, and aims at 0.99 of the tolerance.
"""


def greedy_row(name, tolerance, ours, numpy, real):
    """Base points and errors of both programs."""
    return [
        name, f"{tolerance:g}", span([max(ours["real"]["base_points"])]), f"{real:,}", span(ours["constant"]["base_points"]),
        f"{numpy['constant']:,}", f"{max(ours['constant']['error']) / tolerance:.0f}", f"{numpy['constant_error'] / tolerance:.0f}",
    ]  # fmt: skip


def verdict(runs):
    """What the errors of the three methods say, in words."""
    over = [max(run["constant"]["error"]) / float(tolerance) for tolerance, run in runs.items()]
    most = [run["sequence"]["base_points"][0] / max(run["real"]["base_points"]) for run in runs.values()]
    times = " to ".join(sorted({f"{min(most):.2f}", f"{max(most):.2f}"}))
    return f"""
`sequence` meets its tolerance at every azimuth with one selection, of {times} times the points that
Algorithm 1 takes at its hardest azimuth. Algorithm 2 sees the size of the motion and not its shape: its error is
{min(over):.0f} to {max(over):.0f} times the tolerance. The paper calls the error of its Algorithm 2 comparable to that of Algorithm 1; we do not find that.
"""


def table4(results):
    """The M427 blade over a revolution."""
    result = results["table4"]
    runs = result["runs"]
    rows = revolution_rows(runs, lambda tolerance: f" ({tolerance / 0.3:.1e} c)")
    return f"""
## The M427 blade (table 4, figures 15 and 16)

A blade of chord 0.3 m from 0.9 to 5.625 m, twisted by -8 degrees, in a cylinder of radius 1.5 m:
{size(result["mesh"])}. Pitch 10.04 - 7.65 sin(psi) - 0.96 cos(psi), flap 2.619 + 3.211 sin(psi) - 0.421 cos(psi) degrees, every 10 degrees.
Tolerances in m and, in brackets, in chords.

{table(REVOLUTION, rows)}

SJ is at least {result["before"]["min_scaled_jacobian"]:.3f} in the reference mesh. Columns are as above. {on_busy(runs)} {unjudged(result)} The paper, on 7,937,491 nodes with 668,702 at surfaces, 16 processors:

{table(["", "tolerance", "base points", "selection, one revolution, s", "deformation, 360 steps, s"], PAPER_TABLE_4)}

So at 7.5e-5 m the paper's Algorithm 1 takes fewer points than Algorithm 1 does here. At that tolerance the run at full size below takes about as many
points as the paper's Algorithm 2 at its own tolerance.

![base points and error against azimuth](pictures/paper_m427.png)

{verdict(runs)}
"""


def cost(results):
    """Selection and evaluation against base points."""
    result = results["cost"]
    points = paper_plots.formulas(result)
    rows = []
    for i, run in enumerate(result["runs"]):
        rows.append([
            f"{run['tolerance']:g}", f"{points['n'][i]:,.0f}", points["sweeps"][i],
            seconds(points["selection"][i]), seconds(points["selection_formula"][i]),
            seconds(points["evaluation"][i]), seconds(points["evaluation_formula"][i]), seconds(points["step"][i]),
        ])  # fmt: skip
    header = ["tolerance, m", "base points", "sweeps", "selection, s", "formula", "evaluation, s", "formula", "step, s"]
    run = result["runs"][0]
    return f"""
### Cost against base points

The same blade, {run["surface_points"]:,} surface points and {run["nodes"]:,} nodes, method `sequence`, no correction, no quality.
The formulas are

    selection   a N_s sum n_k + b (m n^2 + n^3/3)    n_k base points at each sweep, and the last set once more; m candidates a round
    evaluation  a N_v n + c                          {run["modes"]} modes at all nodes

with `a` = {1e9 * points["a"]:.2f} ns an evaluation of the kernel (both cores), `b` = {1e9 * points["b"]:.3f} ns a multiply-add
and `c` = {points["c"]:.2f} s fitted to these runs.

{table(header, rows)}

![cost against base points](pictures/paper_cost.png)

The paper evaluates its base points again at each step. Here this is done once for the whole sequence; after that the cost of a step does
not depend on their number (last column, without writing).
"""


def m427(whole):
    """The whole mesh of the paper's size; what validation/m427.py measured."""
    import m427 as script

    made = whole[0]
    return f"""
## The M427 blade at the paper's size (table 4)

`validation/m427.py`: {made["nodes"]:,} nodes, {made["surface_points"]:,} of them on boundaries, one revolution, the
motion above, support radius one blade radius, tolerance {made["tolerance"]:g} m,
method `sequence`.

{script.markdown(whole)}
{script.NOTES}
"""

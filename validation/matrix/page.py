"""docs/matrix.md: how many files of each format are read, and every file with its result."""

import collections

HEAD = """# Every real file

Files of 40 public repositories and of programs in use, each read by azimesh and by another program, and
compared node by node (to the bit), cell by cell, tag by tag and array by array. `python validation/matrix`
makes this page; it takes the folder of the files from `AZIMESH_TESTDATA`.
[ADF](matrix_adf.md), [Fluent](matrix_fluent.md), [OpenFOAM](matrix_openfoam.md), and [Exodus and Plot3D](matrix_exodus.md) have pages of their own.

"""


def family(name):
    """The row of the summary that a format of INDEX.tsv belongs to."""
    for start, title in (("Gmsh", None), ("VTK legacy", None), ("CGNS", "CGNS"), ("SU2", "SU2"),
                         ("UnstructuredGrid", "VTU"), ("PUnstructuredGrid", "PVTU")):
        if name.startswith(start):
            return title or " ".join(name.split()[:2 + (start == "VTK legacy")])
    return "no mesh of a known format"


def counts(results):
    table = collections.OrderedDict()
    for result in sorted(results, key=lambda r: family(r["format"])):
        row = table.setdefault(family(result["format"]), collections.Counter())
        row[result["verdict"]] += 1
        row["compared"] += bool(result.get("peer")) and result["verdict"] == "read"
    return table


def summary(results):
    lines = ["| format | files | read | of them the same as a peer | refused | wrong |", "|---|---|---|---|---|---|"]
    total = collections.Counter()
    for name, row in counts(results).items():
        total.update(row)
        lines.append(line(name, row))
    lines.append(line("all", total))
    return "\n".join(lines)


def line(name, row):
    files = row["read"] + row["refused"] + row["wrong"]
    return f"| {name} | {files} | {row['read']} | {row['compared']} | {row['refused']} | {row['wrong']} |"


def text(results):
    parts = [HEAD, summary(results), "\n"]
    ordered = sorted(results, key=lambda r: (family(r["format"]), r["path"]))
    for name in counts(results):
        parts.append(f"\n## {name}\n\n| file | stored as | result |\n|---|---|---|\n")
        for result in ordered:
            if family(result["format"]) == name:
                stored = result["format"].split("{")[0].strip()
                parts.append(f"| {result['path']} | {cell(stored)} | {cell(told(result))} |\n")
    return "".join(parts)


def cell(words):
    return words.replace("|", "\\|").replace("\n", " ")


def told(result):
    if result["verdict"] == "wrong":
        return "**wrong**: " + "; ".join(result["wrong"])
    if result["verdict"] == "refused":
        said = f"refused: {result['sentence']}"
        if result["readers"]:
            said += f" ({', '.join(result['readers'])} reads it. {result['reason']})"
        return said
    alone = "read, no peer agrees" if any(" differs: " in line for line in result["against"]) else (
        "read, no peer reads it")
    said = f"same as {result['peer'].removesuffix('_su2')}" if result["peer"] else alone
    extra = list(dict.fromkeys(result["remarks"] + result["notes"] + result["against"]))
    return said + ("; " + "; ".join(extra) if extra else "")

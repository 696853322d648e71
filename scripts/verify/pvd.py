"""The time series: every step opens in VTK's PVD reader with its own time and nodes."""

import numpy as np
import pyvista

import outputs
from cases import CASES
from program import report, scratch


def main():
    """Compares times with steps.csv, and nodes with the step's own file."""
    case = CASES[0]
    with scratch() as folder:
        out = folder / "out"
        rows = outputs.deform(case.mesh, case.write(folder, "sequence"), out)
        series, = out.glob("*.pvd")
        reader = pyvista.PVDReader(str(series))
        times = [float(row["time_s"] or row["azimuth_deg"]) for row in rows]
        assert len(reader.time_values) == len(rows), f"{len(reader.time_values)} steps, not {len(rows)}"
        largest = np.abs(np.subtract(reader.time_values, times)).max()
        for time, row in zip(reader.time_values, rows):
            reader.set_active_time_value(time)
            block, = reader.read()
            assert np.array_equal(block.points, outputs.points(out, row)), f"{row['file']} differs"
    report("pvd", len(rows), largest, "steps")
    assert largest <= 1e-9


if __name__ == "__main__":
    main()

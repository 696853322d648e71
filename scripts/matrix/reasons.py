"""Why some files that a peer reads are refused."""

# part of the path, part of the sentence azimesh gives, why
REASONS = [
    ("", "ADF", "ADF is CGNS's old container; the CGNS tools convert it to HDF5 (adf2hdf)"),
]


def reason(row, sentence):
    """The reason for this file and this sentence; None where there is none."""
    for path, said, why in REASONS:
        if path in row["path"] and said in sentence:
            return why
    return None


# part of the path, why azimesh is right where every peer that reads it gives something else
PEERS_WRONG = []


def peer_reason(path):
    """Why no peer agrees on this file; None where one must."""
    return next((why for part, why in PEERS_WRONG if part in str(path)), None)

"""Why some files that a peer reads are refused."""

# part of the path, part of the sentence azimesh gives, why
REASONS = [
    ("testhybrid2.msh", "a quadrilateral needs 4 nodes",
     "its triangles are numbered as quadrilaterals; meshio makes cells of what follows"),
]


def reason(row, sentence):
    """The reason for this file and this sentence; None where there is none."""
    for path, said, why in REASONS:
        if path in row["path"] and said in sentence:
            return why
    return None


# part of the path, why azimesh is right where every peer that reads it gives something else
PEERS_WRONG = [
    ("bike_original.obj_curved.msh", "it mixes triangles of first and third order, of which gmsh keeps the "
     "corners only"),
    ("misc/partitions.msh", "its nodes are numbered from 0, which meshio takes for the last one"),
    ("meshes/cow.msh", "its nodes are numbered from 0; gmsh keeps three of them and meshio takes 0 for "
     "the last one"),
]


def peer_reason(path):
    """Why no peer agrees on this file; None where one must."""
    return next((why for part, why in PEERS_WRONG if part in str(path)), None)

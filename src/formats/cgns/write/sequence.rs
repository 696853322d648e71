//! A sequence of meshes in one file: one GridCoordinates_t a step, one solution a step of arrays at
//! nodes and one of arrays at cells, pointers of the zone to those of each step, and times.

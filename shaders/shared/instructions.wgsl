// Flags of the instructions of an elimination: the target is (divided by) a pivot; it begins with nothing, for it is an update.
const PIVOT: u32 = 1u;
const UPDATE: u32 = 2u;

// Flags of an elimination's instructions: the target is (multiplied by) a pivot; the target starts from zero, as an
// update.
const PIVOT: u32 = 1u;
const UPDATE: u32 = 2u;

// Bindings of all stages. The number of a variant in an entry is at `entry * variants + variant`, so that neighbouring
// invocations, which work on neighbouring variants, read neighbouring words.

// Sizes and offsets, the same for all variants; in words of `program` (…_program), in entries of the other buffers.
struct Offsets {
    variants: u32,
    variables: u32,
    segments: u32,
    station_segments: u32,
    couplings: u32,
    springs: u32,
    holds: u32,
    numbers: u32,
    chunks: u32,
    totals: u32,
    kinds_program: u32,
    holds_program: u32,
    segments_program: u32,
    station_segments_program: u32,
    couplings_program: u32,
    springs_program: u32,
    forces_program: u32,
    condensation_program: u32,
    variables_numbers: u32,
    holds_numbers: u32,
    segments_numbers: u32,
    station_segments_numbers: u32,
    couplings_numbers: u32,
    springs_numbers: u32,
    segments_parts: u32,
    station_segments_parts: u32,
    couplings_parts: u32,
    springs_parts: u32,
    step_vectors: u32,
    descent_vectors: u32,
    gradient_vectors: u32,
    energies_vectors: u32,
    partials_vectors: u32,
    totals_vectors: u32,
    negatives_vectors: u32,
}

// Items of a dispatch, for variants in the given phases; slot of the state, and start of the dispatch's table in the
// program.
struct Range {
    first: u32,
    count: u32,
    phases: u32,
    slot: u32,
    table: u32,
}

// Status of a variant. `phase` selects the stages that process it.
struct Control {
    force_scale: real,
    moment_scale: real,
    tolerance: real,
    noise: real,
    energy: real,
    trial_energy: real,
    slope: real,
    alpha: real,
    max_rotation: real,
    sigma: real,
    residual: real,
    trial_residual: real,
    last_rotation: real,
    unit: real,
    beta: real,
    product: real,
    phase: u32,
    outcome: u32,
    current: u32,
    moving: u32,
    begun: u32,
    iterations: u32,
    factorisations: u32,
    evaluations: u32,
    stalled: u32,
    polished: u32,
    max_iterations: u32,
    negative: u32,
    algorithm: u32,
    previous: u32,
    since: u32,
    cycles: u32,
    patience: u32,
}

@group(0) @binding(0) var<uniform> offsets: Offsets;
@group(0) @binding(1) var<uniform> range: Range;
@group(0) @binding(2) var<storage, read> program: array<u32>;
@group(0) @binding(3) var<storage, read_write> numbers: array<real>;
@group(0) @binding(4) var<storage, read_write> state: array<real>;
@group(0) @binding(5) var<storage, read_write> parts: array<real>;
@group(0) @binding(6) var<storage, read_write> blocks: array<real>;
@group(0) @binding(7) var<storage, read_write> vectors: array<real>;
@group(0) @binding(8) var<storage, read_write> control: array<Control>;
// Uploaded and read back: here the numbers of a variant are together.
@group(0) @binding(9) var<storage, read_write> transfer: array<real>;

const NONE: u32 = 0xffffffffu;

const LINEARISE: u32 = 0u;
const REFACTOR: u32 = 1u;
const SOLVE: u32 = 2u;
const SEARCH: u32 = 3u;
const CONDENSE: u32 = 4u;
const ACCEPT: u32 = 5u;
const DESCEND: u32 = 6u;
const COMBINE: u32 = 7u;
const DONE: u32 = 8u;

// Slots of the state: current state, trial state, and condensed trial state.
const CURRENT: u32 = 0u;
const TRIAL: u32 = 1u;
const CONDENSED: u32 = 2u;

// Item and variant of an invocation; not present beyond the range, or if the variant is in another phase.
struct Item {
    index: u32,
    variant: u32,
    present: bool,
}

fn item(group: vec3<u32>, groups: vec3<u32>, local: u32) -> Item {
    let i = (group.y * groups.x + group.x) * 64u + local;
    let index = i / offsets.variants;
    let variant = i % offsets.variants;
    let present = index < range.count && ((range.phases >> control[variant].phase) & 1u) == 1u;
    return Item(range.first + index, variant, present);
}

fn number(entry: u32, variant: u32) -> real {
    return numbers[entry * offsets.variants + variant];
}

fn number3(entry: u32, variant: u32) -> vec3<real> {
    return vec3<real>(number(entry, variant), number(entry + 1u, variant), number(entry + 2u, variant));
}

fn number4(entry: u32, variant: u32) -> vec4<real> {
    return vec4<real>(number3(entry, variant), number(entry + 3u, variant));
}

// Entry of a variable in a slot of the state.
fn state_entry(variable: u32, slot: u32, variant: u32) -> u32 {
    let own = (control[variant].current + slot) % 3u;
    return (own * offsets.variables + variable) * 7u;
}

fn state_at(entry: u32, variant: u32) -> real {
    return state[entry * offsets.variants + variant];
}

fn value3(entry: u32, variant: u32) -> vec3<real> {
    return vec3<real>(state_at(entry, variant), state_at(entry + 1u, variant), state_at(entry + 2u, variant));
}

fn value4(entry: u32, variant: u32) -> vec4<real> {
    return vec4<real>(value3(entry, variant), state_at(entry + 3u, variant));
}

fn compensation3(entry: u32, variant: u32) -> vec3<real> {
    return value3(entry + 4u, variant);
}

fn set_state(entry: u32, variant: u32, x: real) {
    state[entry * offsets.variants + variant] = x;
}

fn set_state3(entry: u32, variant: u32, x: vec3<real>) {
    set_state(entry, variant, x.x);
    set_state(entry + 1u, variant, x.y);
    set_state(entry + 2u, variant, x.z);
}

fn set_part(entry: u32, variant: u32, x: real) {
    parts[entry * offsets.variants + variant] = x;
}

fn set_part3(entry: u32, variant: u32, x: vec3<real>) {
    set_part(entry, variant, x.x);
    set_part(entry + 1u, variant, x.y);
    set_part(entry + 2u, variant, x.z);
}

fn set_part33(entry: u32, variant: u32, m: mat3x3<real>) {
    set_part3(entry, variant, m[0]);
    set_part3(entry + 3u, variant, m[1]);
    set_part3(entry + 6u, variant, m[2]);
}

fn part(entry: u32, variant: u32) -> real {
    return parts[entry * offsets.variants + variant];
}

fn part3(entry: u32, variant: u32) -> vec3<real> {
    return vec3<real>(part(entry, variant), part(entry + 1u, variant), part(entry + 2u, variant));
}

fn part33(entry: u32, variant: u32) -> mat3x3<real> {
    return mat3x3<real>(part3(entry, variant), part3(entry + 3u, variant), part3(entry + 6u, variant));
}

fn vector(entry: u32, variant: u32) -> real {
    return vectors[entry * offsets.variants + variant];
}

fn vector3(entry: u32, variant: u32) -> vec3<real> {
    return vec3<real>(vector(entry, variant), vector(entry + 1u, variant), vector(entry + 2u, variant));
}

fn set_vector(entry: u32, variant: u32, x: real) {
    vectors[entry * offsets.variants + variant] = x;
}

fn set_vector3(entry: u32, variant: u32, x: vec3<real>) {
    set_vector(entry, variant, x.x);
    set_vector(entry + 1u, variant, x.y);
    set_vector(entry + 2u, variant, x.z);
}

fn block_at(entry: u32, variant: u32) -> real {
    return blocks[entry * offsets.variants + variant];
}

fn block_column(entry: u32, variant: u32) -> vec3<real> {
    return vec3<real>(block_at(entry, variant), block_at(entry + 1u, variant), block_at(entry + 2u, variant));
}

// Entry of a variable in the free gradient of a slot of the state.
fn gradient_entry(variable: u32, slot: u32, variant: u32) -> u32 {
    return gradient_of((control[variant].current + slot) % 3u, variable);
}

fn gradient_of(own: u32, variable: u32) -> u32 {
    return offsets.gradient_vectors + (own * offsets.variables + variable) * 3u;
}

// Prescribed motion of a variable in its first step.
fn motion(variable: u32, variant: u32) -> vec3<real> {
    let hold = program[offsets.holds_program + variable];
    if hold == NONE || control[variant].moving == 0u {
        return vec3<real>(real(0.0), real(0.0), real(0.0));
    }
    return number3(offsets.holds_numbers + 20u * hold + 17u, variant);
}

// Block b of the matrix, of its factor, or of an update.
fn block33(b: u32, variant: u32) -> mat3x3<real> {
    let entry = 9u * b;
    return mat3x3<real>(
        block_column(entry, variant),
        block_column(entry + 3u, variant),
        block_column(entry + 6u, variant),
    );
}

fn set_block_column(entry: u32, variant: u32, x: vec3<real>) {
    blocks[entry * offsets.variants + variant] = x.x;
    blocks[(entry + 1u) * offsets.variants + variant] = x.y;
    blocks[(entry + 2u) * offsets.variants + variant] = x.z;
}

// Without loops over components: a compiler that does not unroll them keeps the matrix in memory.
fn set_block33(b: u32, variant: u32, m: mat3x3<real>) {
    let entry = 9u * b;
    set_block_column(entry, variant, m[0]);
    set_block_column(entry + 3u, variant, m[1]);
    set_block_column(entry + 6u, variant, m[2]);
}

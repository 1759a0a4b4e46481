//! Plan of a harness: everything that depends on its topology only, computed once on the CPU.
//!
//! Variables are numbered in elimination order. `program` has the look-up tables of the stages: the variables of every
//! part, the parts whose derivatives sum up to every variable and block, and the instructions of the elimination.
//! [`Plan::cycle`] lists the dispatches of a cycle.

use crate::Stage;
use crate::elimination::{Elimination, Instructions};
use crate::harness::{NONE, Topology, Variable};
use crate::layout::{Offsets, Phase, Range};

/// Flag of a source: subtracted.
pub(crate) const NEGATIVE: u32 = 1 << 31;
/// Flag of a source: transposed.
pub(crate) const TRANSPOSED: u32 = 1 << 30;

/// Number of entries of each part and of its derivatives; types of parts in the order of their energies.
pub(crate) mod sizes {
    /// Dead force, weight.
    pub(crate) const VARIABLE: u32 = 4;
    /// Basis, count, target, motion.
    pub(crate) const HOLD: u32 = 20;
    /// C, ℓ, B.
    pub(crate) const SEGMENT: u32 = 6;
    /// C, ℓ, B; of both stations rest, offset, β.
    pub(crate) const STATION_SEGMENT: u32 = 22;
    /// C, λ, κ°, both rests.
    pub(crate) const COUPLING: u32 = 15;
    /// Rest, offset, k, k_t, k_f, X°, S°, F.
    pub(crate) const SPRING: u32 = 20;
    /// Two gradients, three blocks: segments, couplings and springs.
    pub(crate) const PART: u32 = 33;
    /// Four gradients, ten blocks.
    pub(crate) const STATION_PART: u32 = 102;
    /// Value and compensation.
    pub(crate) const STATE: u32 = 7;
    /// Energy, slope; largest force, moment and rotation (squared); products with the previous gradient and of the
    /// previous step.
    pub(crate) const PARTIAL: u32 = 7;
}

/// One dispatch: a stage over a range of items of every variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dispatch {
    /// The stage.
    pub stage: Stage,
    /// Its items and phases.
    pub range: Range,
}

impl Dispatch {
    /// Number of workgroups, with an invocation for every item of every variant.
    pub fn workgroups(&self, variants: u32) -> [u32; 3] {
        /// Largest number in one direction that every device allows.
        const MOST: u64 = 65_535;
        let size = u64::from(self.stage.workgroup_size());
        let groups = (u64::from(self.range.count) * u64::from(variants)).div_ceil(size);
        let rows = groups.div_ceil(MOST).max(1);
        [groups.div_ceil(rows) as u32, rows as u32, 1]
    }
}

/// Order, tables and dispatches for a topology; see the module.
pub struct Plan {
    /// The topology.
    pub topology: Topology,
    /// The variable at each position of the elimination order.
    pub variables: Vec<Variable>,
    /// Position of each point.
    pub of_point: Vec<u32>,
    /// Position of each frame.
    pub of_frame: Vec<u32>,
    /// The elimination of all variables.
    pub elimination: Elimination,
    /// The elimination of the points alone, with fixed frames.
    pub condensation: Elimination,
    tables: [Tables; 2],
    /// Look-up tables and instructions of the stages.
    pub program: Vec<u32>,
    /// Sizes and offsets, for one variant.
    pub offsets: Offsets,
    /// Number of entries of `parts`.
    pub parts: u32,
    /// Number of entries of `vectors`.
    pub vectors: u32,
    /// Number of derivatives in the sums of all variables, and of all blocks of both matrices.
    pub(crate) sources_of_forces: u32,
    pub(crate) sources_of_blocks: [u32; 2],
    cycle: Vec<Dispatch>,
}

/// Lists of the derivatives in each sum.
type Sources = Vec<Vec<u32>>;

impl Plan {
    /// For harnesses with this topology. Parts of at most `leaf` variables are eliminated by one invocation: few for
    /// one large harness, `usize::MAX` for thousands of variants.
    ///
    /// # Panics
    /// If the topology names a variable that does not exist, or has more than 2³⁰ derivatives.
    pub fn new(topology: Topology, leaf: usize) -> Self {
        let points = topology.points as u32;
        let vertex = |variable: Variable| match variable {
            Variable::Point(i) => i,
            Variable::Frame(c) => points + c,
        };
        let elimination = Elimination::new(&graph(&topology, vertex), leaf, 0, 0);
        let variables: Vec<Variable> = elimination
            .order
            .iter()
            .map(|&v| if v < points { Variable::Point(v) } else { Variable::Frame(v - points) })
            .collect();
        let (blocks, vectors) = (elimination.blocks_end, elimination.vectors_end);
        let condensation = Elimination::new(&points_graph(&topology), leaf, blocks, vectors);
        let mut place = vec![0; variables.len()];
        for (p, &v) in elimination.order.iter().enumerate() {
            place[v as usize] = p as u32;
        }
        let of_frame = place.split_off(topology.points);
        let mut plan = Self {
            topology,
            variables,
            of_point: place,
            of_frame,
            elimination,
            condensation,
            tables: Default::default(),
            program: Vec::new(),
            offsets: Offsets::default(),
            parts: 0,
            vectors: 0,
            sources_of_forces: 0,
            sources_of_blocks: [0; 2],
            cycle: Vec::new(),
        };
        plan.give_places();
        plan.write_program();
        plan.cycle = plan.list_cycle();
        plan
    }

    /// Dispatches of a cycle, in order; empty ones are left out.
    pub fn cycle(&self) -> &[Dispatch] {
        &self.cycle
    }

    /// The dispatch after an upload, which distributes what [`crate::memory::pack`] gives of every variant that begins.
    pub fn unpack(&self) -> Dispatch {
        let phases = (1 << Phase::Done as u32) - 1;
        Dispatch { stage: Stage::Unpack, range: Range { count: self.upload_length(), phases, ..Range::default() } }
    }

    /// The dispatch before a read-back, which packs the states of all variants for [`crate::memory::unpack_shape`].
    pub fn pack_shape(&self) -> Dispatch {
        let phases = (1 << (Phase::Done as u32 + 1)) - 1;
        Dispatch { stage: Stage::PackShape, range: Range { count: self.shape_length(), phases, ..Range::default() } }
    }

    /// Count of the numbers of a variant that are uploaded.
    pub fn upload_length(&self) -> u32 {
        self.offsets.numbers + self.shape_length()
    }

    /// Count of the numbers of a variant's state.
    pub fn shape_length(&self) -> u32 {
        sizes::STATE * self.offsets.variables
    }

    /// Number of variables.
    pub fn len(&self) -> usize {
        self.variables.len()
    }

    /// Whether there are no variables.
    pub fn is_empty(&self) -> bool {
        self.variables.is_empty()
    }

    /// Position of a variable.
    pub fn place(&self, variable: Variable) -> u32 {
        match variable {
            Variable::Point(i) => self.of_point[i as usize],
            Variable::Frame(c) => self.of_frame[c as usize],
        }
    }

    /// Number of parts of all types.
    pub fn part_count(&self) -> u32 {
        let p = &self.offsets;
        p.segments + p.station_segments + p.couplings + p.springs
    }

    fn give_places(&mut self) {
        let (topology, p) = (&self.topology, &mut self.offsets);
        p.variants = 1;
        p.variables = self.variables.len() as u32;
        p.segments = topology.segments.len() as u32;
        p.station_segments = topology.station_segments.len() as u32;
        p.couplings = topology.couplings.len() as u32;
        p.springs = topology.springs.len() as u32;
        p.holds = topology.holds.len() as u32;
        let count = p.segments + p.station_segments + p.couplings + p.springs;
        // Sums in three steps of the same sequential length: items of a chunk, chunks of a total, totals.
        p.totals = f64::from(p.variables.max(count)).cbrt().ceil().max(1.0) as u32;
        p.chunks = p.totals * p.totals;
        let mut numbers = 0;
        for (place, count, size) in [
            (&mut p.variables_numbers, p.variables, sizes::VARIABLE),
            (&mut p.holds_numbers, p.holds, sizes::HOLD),
            (&mut p.segments_numbers, p.segments, sizes::SEGMENT),
            (&mut p.station_segments_numbers, p.station_segments, sizes::STATION_SEGMENT),
            (&mut p.couplings_numbers, p.couplings, sizes::COUPLING),
            (&mut p.springs_numbers, p.springs, sizes::SPRING),
        ] {
            *place = numbers;
            numbers += count * size;
        }
        let mut parts = 0;
        for (place, count, size) in [
            (&mut p.segments_parts, p.segments, sizes::PART),
            (&mut p.station_segments_parts, p.station_segments, sizes::STATION_PART),
            (&mut p.couplings_parts, p.couplings, sizes::PART),
            (&mut p.springs_parts, p.springs, sizes::PART),
        ] {
            *place = parts;
            parts += count * size;
        }
        let mut vectors = 3 * self.condensation.vectors_end;
        for (place, size) in [
            (&mut p.step_vectors, 3 * p.variables),
            (&mut p.descent_vectors, 3 * p.variables),
            (&mut p.gradient_vectors, 9 * p.variables),
            (&mut p.energies_vectors, count),
            (&mut p.partials_vectors, sizes::PARTIAL * p.chunks),
            (&mut p.totals_vectors, sizes::PARTIAL * p.totals),
            (&mut p.negatives_vectors, self.elimination.tasks.len().max(self.condensation.tasks.len()) as u32),
        ] {
            *place = vectors;
            vectors += size;
        }
        assert!(parts < TRANSPOSED, "a harness with more than 2^30 derivatives");
        p.numbers = numbers;
        (self.parts, self.vectors) = (parts, vectors);
    }

    fn write_program(&mut self) {
        let [forces, blocks, condensation] = self.sources();
        let count = |sources: &Sources| sources.iter().map(Vec::len).sum::<usize>() as u32;
        self.sources_of_forces = count(&forces);
        self.sources_of_blocks = [count(&blocks), count(&condensation)];
        let topology = &self.topology;
        let (point, frame) = (|i: u32| self.of_point[i as usize], |c: u32| self.of_frame[c as usize]);
        let some_frame = |c: u32| if c == NONE { NONE } else { frame(c) };
        let mut holds = vec![NONE; self.variables.len()];
        for (k, &variable) in topology.holds.iter().enumerate() {
            holds[self.place(variable) as usize] = k as u32;
        }
        let mut words: Vec<u32> = Vec::new();
        let p = &mut self.offsets;
        let mut append = |place: &mut u32, own: Vec<u32>| {
            *place = words.len() as u32;
            words.extend(own);
        };
        let kinds = self.variables.iter().map(|variable| u32::from(matches!(variable, Variable::Frame(_))));
        append(&mut p.kinds_program, kinds.collect());
        append(&mut p.holds_program, holds);
        let segments = topology.segments.iter().flat_map(|s| [point(s[0]), point(s[1]), frame(s[2])]);
        append(&mut p.segments_program, segments.collect());
        let station_segments = topology
            .station_segments
            .iter()
            .flat_map(|s| [point(s[0]), point(s[1]), frame(s[2]), some_frame(s[3]), some_frame(s[4])]);
        append(&mut p.station_segments_program, station_segments.collect());
        append(&mut p.couplings_program, topology.couplings.iter().flatten().map(|&c| frame(c)).collect());
        append(&mut p.springs_program, topology.springs.iter().flat_map(|s| [point(s[0]), some_frame(s[1])]).collect());
        append(&mut p.forces_program, sum_table(&forces, |_| []));
        let condensed = self.condensation.order.iter().map(|&i| self.of_point[i as usize]);
        let condensed: Vec<u32> = condensed.collect();
        let mut condensed_vector = vec![NONE; self.variables.len()];
        for (vector, &variable) in (self.condensation.first_vector..).zip(&condensed) {
            condensed_vector[variable as usize] = vector;
        }
        append(&mut p.condensation_program, condensed_vector);
        let all: Vec<u32> = (0..self.variables.len() as u32).collect();
        let systems = [(&self.elimination, &blocks, all), (&self.condensation, &condensation, condensed)];
        for (tables, (elimination, blocks, variables)) in self.tables.iter_mut().zip(systems) {
            let mut offsets = vec![[0; 3]; blocks.len()];
            let mut put = |block: u32, row: u32, column: u32| {
                let place = &mut offsets[(block - elimination.first_pivot) as usize];
                *place = [block, variables[row as usize], variables[column as usize]];
            };
            for column in 0..elimination.len() as u32 {
                put(elimination.first_pivot + column, column, column);
                for (block, &row) in
                    (elimination.first_block[column as usize]..).zip(&elimination.rows[column as usize])
                {
                    put(block, row, column);
                }
            }
            append(&mut tables.blocks, sum_table(blocks, |block| offsets[block]));
            let vectors = (elimination.first_vector..).zip(&variables);
            append(&mut tables.right_hand_side, vectors.flat_map(|(vector, &variable)| [vector, variable]).collect());
            let roots = elimination.roots();
            append(&mut tables.roots, [roots.len() as u32].into_iter().chain(roots).collect());
            append(&mut tables.factor, instruction_table(&elimination.factor));
            append(&mut tables.forward, instruction_table(&elimination.forward));
            append(&mut tables.backward, instruction_table(&elimination.backward));
        }
        self.program = words;
    }

    /// Derivatives that sum up to every variable, to every block of the matrix, and to every block of the points'
    /// matrix.
    fn sources(&self) -> [Sources; 3] {
        let mut sources = Assembly {
            systems: [System::new(&self.elimination), System::new(&self.condensation)],
            condensed: vec![NONE; self.variables.len()],
            forces: vec![Vec::new(); self.variables.len()],
        };
        for (position, &i) in (0..).zip(&self.condensation.order) {
            sources.condensed[self.of_point[i as usize] as usize] = position;
        }
        let (topology, offsets) = (&self.topology, &self.offsets);
        let (point, frame) = (|i: u32| self.of_point[i as usize], |c: u32| self.of_frame[c as usize]);
        for (k, &[a, b, f]) in (0..).zip(&topology.segments) {
            let [a, b, f] = [point(a), point(b), frame(f)];
            let entry = offsets.segments_parts + sizes::PART * k;
            sources.edge(a, b, entry, entry + 6);
            sources.force(f, entry + 3);
            sources.across_edge(f, a, b, entry + 15);
            sources.block(f, f, entry + 24);
        }
        for (k, &[a, b, f, first, second]) in (0..).zip(&topology.station_segments) {
            let [a, b, f] = [point(a), point(b), frame(f)];
            let entry = offsets.station_segments_parts + sizes::STATION_PART * k;
            let block = |k: u32| entry + 12 + 9 * k;
            sources.edge(a, b, entry, block(0));
            sources.force(f, entry + 3);
            sources.across_edge(f, a, b, block(1));
            sources.block(f, f, block(2));
            for (station, force, first_block) in [(first, entry + 6, 3), (second, entry + 9, 6)] {
                if station == NONE {
                    continue;
                }
                let q = frame(station);
                sources.force(q, force);
                sources.across_edge(q, a, b, block(first_block));
                sources.block(q, f, block(first_block + 1));
                sources.block(q, q, block(if first_block == 3 { 5 } else { 9 }));
            }
            if first != NONE && second != NONE {
                sources.mixed(frame(second), frame(first), block(8));
            }
        }
        for (k, &[a, b]) in (0..).zip(&topology.couplings) {
            let [a, b] = [frame(a), frame(b)];
            let entry = offsets.couplings_parts + sizes::PART * k;
            sources.force(a, entry);
            sources.force(b, entry + 3);
            sources.block(a, a, entry + 6);
            sources.mixed(a, b, entry + 15);
            sources.block(b, b, entry + 24);
        }
        for (k, &[x, q]) in (0..).zip(&topology.springs) {
            let x = point(x);
            let entry = offsets.springs_parts + sizes::PART * k;
            sources.force(x, entry);
            sources.block(x, x, entry + 6);
            if q != NONE {
                let q = frame(q);
                sources.force(q, entry + 3);
                sources.block(q, x, entry + 15);
                sources.block(q, q, entry + 24);
            }
        }
        let [all, points] = sources.systems.map(|system| system.blocks);
        [sources.forces, all, points]
    }

    fn list_cycle(&self) -> Vec<Dispatch> {
        use Phase::{Accept, Combine, Condense, Descend, Linearise, Refactor, Search, Solve};
        let p = &self.offsets;
        let mut cycle = Cycle::default();
        let first = [Linearise, Refactor];
        let [all, points] = &self.tables;
        cycle.add(Stage::LineariseSegments, p.segments, &[Linearise]);
        cycle.add(Stage::LineariseStationSegments, p.station_segments, &[Linearise]);
        cycle.add(Stage::LineariseCouplings, p.couplings, &[Linearise]);
        cycle.add(Stage::LineariseSprings, p.springs, &[Linearise]);
        cycle.factorise(&self.elimination, all, &first);
        cycle.add(Stage::CheckInertia, 1, &first).table = all.roots;
        cycle.add(Stage::LoadGradient, p.variables, &[Descend]).table = all.right_hand_side;
        cycle.solve(&self.elimination, all, &[Solve, Descend]);
        cycle.add(Stage::SumStep, p.chunks, &[Solve, Descend]);
        cycle.add(Stage::SumPartials, p.totals, &[Solve, Descend]);
        cycle.add(Stage::BeginLineSearch, 1, &[Solve, Descend]);
        cycle.add(Stage::CombineDirections, p.variables, &[Combine]);
        cycle.add(Stage::Retract, p.variables, &[Combine, Search]);
        cycle.measure(p, &[Combine, Search], 1);
        cycle.add(Stage::RecordTrial, 1, &[Combine, Search]);
        cycle.factorise(&self.condensation, points, &[Condense]);
        cycle.add(Stage::CheckPointsInertia, 1, &[Condense]).table = points.roots;
        cycle.solve(&self.condensation, points, &[Condense]);
        cycle.add(Stage::CondensePoints, p.variables, &[Condense]);
        cycle.measure(p, &[Condense], 2);
        cycle.add(Stage::AcceptStep, 1, &[Condense, Accept]);
        cycle.dispatches.retain(|dispatch| dispatch.range.count > 0);
        cycle.dispatches
    }
}

/// Offsets of the tables of an elimination.
#[derive(Clone, Copy, Debug, Default)]
struct Tables {
    blocks: u32,
    right_hand_side: u32,
    roots: u32,
    factor: u32,
    forward: u32,
    backward: u32,
}

/// Dispatches of a cycle, in order.
#[derive(Default)]
struct Cycle {
    dispatches: Vec<Dispatch>,
}

impl Cycle {
    fn add(&mut self, stage: Stage, count: u32, phases: &[Phase]) -> &mut Range {
        let phases = phases.iter().fold(0, |all, phase| all | 1 << *phase as u32);
        self.dispatches.push(Dispatch { stage, range: Range { count, phases, ..Range::default() } });
        &mut self.dispatches.last_mut().expect("pushed above").range
    }

    /// Assembles a matrix and a right-hand side, and factorises.
    fn factorise(&mut self, elimination: &Elimination, tables: &Tables, phases: &[Phase]) {
        self.add(Stage::AssembleMatrix, elimination.matrix_blocks.len() as u32, phases).table = tables.blocks;
        self.add(Stage::AssembleRightHandSide, elimination.len() as u32, phases).table = tables.right_hand_side;
        for level in &elimination.levels {
            let range = self.add(Stage::Factorise, level.len() as u32, phases);
            (range.first, range.table) = (level.start, tables.factor);
        }
    }

    fn solve(&mut self, elimination: &Elimination, tables: &Tables, phases: &[Phase]) {
        for level in &elimination.levels {
            let range = self.add(Stage::SolveForward, level.len() as u32, phases);
            (range.first, range.table) = (level.start, tables.forward);
        }
        for level in elimination.levels.iter().rev() {
            let range = self.add(Stage::SolveBackward, level.len() as u32, phases);
            (range.first, range.table) = (level.start, tables.backward);
        }
    }

    /// Evaluates energy and free gradient of a slot of the state.
    fn measure(&mut self, p: &Offsets, phases: &[Phase], slot: u32) {
        for (stage, count) in [
            (Stage::EvaluateSegments, p.segments),
            (Stage::EvaluateStationSegments, p.station_segments),
            (Stage::EvaluateCouplings, p.couplings),
            (Stage::EvaluateSprings, p.springs),
            (Stage::AssembleGradient, p.variables),
            (Stage::SumState, p.chunks),
            (Stage::SumPartials, p.totals),
        ] {
            self.add(stage, count, phases).slot = slot;
        }
    }
}

/// Graph of the variables: neighbours share a part.
fn graph(topology: &Topology, vertex: impl Fn(Variable) -> u32) -> Vec<Vec<u32>> {
    let mut graph = vec![Vec::new(); topology.points + topology.frames];
    let mut join = |clique: &[Variable]| {
        for &a in clique {
            let own = vertex(a);
            graph[own as usize].extend(clique.iter().map(|&b| vertex(b)).filter(|&b| b != own));
        }
    };
    let (point, frame) = (Variable::Point, Variable::Frame);
    for &[a, b, f] in &topology.segments {
        join(&[point(a), point(b), frame(f)]);
    }
    for &[a, b, f, first, second] in &topology.station_segments {
        let stations = [first, second].into_iter().filter(|&q| q != NONE).map(frame);
        join(&[point(a), point(b), frame(f)].into_iter().chain(stations).collect::<Vec<_>>());
    }
    for &[a, b] in &topology.couplings {
        join(&[frame(a), frame(b)]);
    }
    for &[x, q] in topology.springs.iter().filter(|spring| spring[1] != NONE) {
        join(&[point(x), frame(q)]);
    }
    for neighbours in &mut graph {
        neighbours.sort_unstable();
        neighbours.dedup();
    }
    graph
}

/// Graph of the points: neighbours share a segment.
fn points_graph(topology: &Topology) -> Vec<Vec<u32>> {
    let mut graph = vec![Vec::new(); topology.points];
    let segments = topology.segments.iter().map(|s| [s[0], s[1]]);
    let edges = segments.chain(topology.station_segments.iter().map(|s| [s[0], s[1]]));
    for [a, b] in edges.filter(|[a, b]| a != b) {
        graph[a as usize].push(b);
        graph[b as usize].push(a);
    }
    for neighbours in &mut graph {
        neighbours.sort_unstable();
        neighbours.dedup();
    }
    graph
}

/// Sums of the blocks of a matrix, while they are collected.
struct System<'e> {
    elimination: &'e Elimination,
    blocks: Sources,
}

impl<'e> System<'e> {
    fn new(elimination: &'e Elimination) -> Self {
        Self { elimination, blocks: vec![Vec::new(); elimination.matrix_blocks.len()] }
    }

    /// Adds a block of second derivatives with respect to two variables, which may be equal.
    fn block(&mut self, row: u32, column: u32, source: u32) {
        let (row, column, source) =
            if row >= column { (row, column, source) } else { (column, row, source ^ TRANSPOSED) };
        let block = self.elimination.block(row, column).expect("variables of one part");
        self.blocks[(block - self.elimination.first_pivot) as usize].push(source);
    }
}

/// Sums of variables and blocks while they are collected, for all variables and for the points alone.
struct Assembly<'e> {
    systems: [System<'e>; 2],
    /// Position of each variable among the points.
    condensed: Vec<u32>,
    forces: Sources,
}

impl Assembly<'_> {
    fn force(&mut self, variable: u32, entry: u32) {
        self.forces[variable as usize].push(entry);
    }

    fn block(&mut self, row: u32, column: u32, source: u32) {
        self.systems[0].block(row, column, source);
        let [row, column] = [row, column].map(|variable| self.condensed[variable as usize]);
        if row != NONE && column != NONE {
            self.systems[1].block(row, column, source);
        }
    }

    /// Adds an off-diagonal block of a part. If both variables are the same, its transpose is added too.
    fn mixed(&mut self, row: u32, column: u32, source: u32) {
        self.block(row, column, source);
        if row == column {
            self.block(row, column, source ^ TRANSPOSED);
        }
    }

    /// Adds derivatives with respect to the edge x_b − x_a.
    fn edge(&mut self, a: u32, b: u32, force: u32, block: u32) {
        self.forces[a as usize].push(force | NEGATIVE);
        self.forces[b as usize].push(force);
        self.block(a, a, block);
        self.block(b, b, block);
        self.mixed(b, a, block | NEGATIVE);
    }

    /// Adds second derivatives with respect to a frame and the edge x_b − x_a.
    fn across_edge(&mut self, frame: u32, a: u32, b: u32, block: u32) {
        self.mixed(frame, a, block | NEGATIVE);
        self.mixed(frame, b, block);
    }
}

/// Table with `[start, head…]` of every sum and a final start, followed by all sources; starts are relative to the
/// table.
fn sum_table<const N: usize>(sources: &Sources, head: impl Fn(usize) -> [u32; N]) -> Vec<u32> {
    let width = 1 + N;
    let mut words = Vec::new();
    let mut start = width * sources.len() + 1;
    for (k, own) in sources.iter().enumerate() {
        words.push(start as u32);
        words.extend(head(k));
        start += own.len();
    }
    words.push(start as u32);
    words.extend(sources.iter().flatten());
    words
}

/// Table of starts, followed by the instructions; starts are relative to the table.
fn instruction_table(instructions: &Instructions) -> Vec<u32> {
    let offset = instructions.starts.len() as u32;
    instructions.starts.iter().map(|start| start + offset).chain(instructions.words.iter().copied()).collect()
}
